// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "common/settings/config_reader.hpp"
#include "mpm_solver/boulders/boulder_settings.hpp"

namespace gabion::mpm {

/// Keys that entries of "boulders" and "random_boulders" share.
std::vector<Key> boulder_law_keys();

/// Read these but `density` and `velocity`, which decide on the mass and the start: the law but for
/// its stiffness, and what the boulder does with soil.
/// @pre the shape is known
template <int dim>
void read_boulder_law(ConfigReader& in, BoulderSettings<dim>& boulder);

/// The stiffness [N/m^2] that a boulder has unless another one is given, and words for it.
template <int dim>
double usual_stiffness(const BoulderShape<dim>& shape);
std::string usual_stiffness_words();

}  // namespace gabion::mpm
