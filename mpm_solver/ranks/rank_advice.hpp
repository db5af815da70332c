// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "mpm_solver/mpm_config.hpp"

namespace gabion::mpm {

/// How many MPI ranks of the soil pay.
struct RankAdvice {
  int ranks = 1;       ///< not more than the cores
  std::string reason;  ///< such as "64000 points in space, 2 cores"
};

/// The advice, by dimension, number of points, and what several ranks cannot do or were not
/// measured with (docs/measured/ranks.md). Depends on nothing but its arguments.
/// @param cores  that the run may use
template <int dim>
RankAdvice advise_ranks(const MpmSettings<dim>& settings, int cores);

}  // namespace gabion::mpm
