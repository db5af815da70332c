// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "mpm_solver/mpm_config.hpp"

namespace gabion::mpm {

/// Refuse what soil whose pore water drains cannot do as yet, and walls that are drained without
/// such soil.
/// @throws ConfigError
template <int dim>
void check_seepage(const ConfigReader& in, const MpmSettings<dim>& settings);

/// The same of ranks: such soil is on one.
void require_one_rank_for_seepage(int num_ranks, const std::string& bodies_where);

}  // namespace gabion::mpm
