// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "common/settings/config_reader.hpp"
#include "fem_solver/materials/concrete.hpp"

namespace gabion::fem {

/// Keys of the law `concrete` beside those of elasticity.
std::vector<Key> concrete_keys();

/// @param in  an object of a table with concrete_keys(), already asked for its law
/// @throws ConfigError  strengths that contradict each other
template <int dim>
Concrete<dim> read_concrete(ConfigReader& in, double lambda, double mu);

}  // namespace gabion::fem
