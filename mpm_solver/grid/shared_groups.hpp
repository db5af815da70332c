// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include "mpm_solver/grid/basis.hpp"

namespace gabion::mpm {

/// Find the groups whose points are spread over several ranks, number them in PointWeights::shared
/// and give each the union of its nodes, in one order on all ranks.
/// @param num_cells  of the grid
/// @note Collective. Does nothing on one rank.
template <int dim>
void share_groups(MPI_Comm comm, std::int32_t num_cells, PointWeights<dim>& weights);

}  // namespace gabion::mpm
