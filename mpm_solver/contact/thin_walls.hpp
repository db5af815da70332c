// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <string>
#include <vector>

#include "mpm_solver/contact/start_check.hpp"

namespace gabion::mpm {

/// What to say where a structure is thinner than a cell and has soil on both sides, within four
/// cells at time 0: that soil shares nodes of the grid, so it acts on itself through the structure.
/// A text for each two surfaces, which may be the same, that are the faces of such a place. Not for
/// the mode `fixed`, which soil sticks to on all sides.
/// @param cell_size  mean [m]
/// @note Collective.
template <int dim>
std::vector<std::string> thin_walls(MPI_Comm comm, const std::vector<StartSurface<dim>>& surfaces,
                                    const MaterialPoints<dim>& points, double cell_size);

}  // namespace gabion::mpm
