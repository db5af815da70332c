// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <string>
#include <vector>

#include "mpm_solver/contact/start_check.hpp"
#include "mpm_solver/mpm_config.hpp"

namespace gabion::mpm {

/// Material points that a surface has laid against it at time 0, and those of them in cells that
/// it cuts.
struct CutCells {
  std::int64_t touching = 0;  ///< points that are no farther than their own size
  std::int64_t in_cut = 0;    ///< of these, in cells with room on both sides of the surface
};

/// Cells that surfaces cut, counted over this rank's points. Facets along the lines of the grid cut
/// no cell.
template <int dim>
std::vector<CutCells> cut_cells_at(const std::vector<StartSurface<dim>>& surfaces,
                                   const BackgroundGrid<dim>& grid,
                                   const MaterialPoints<dim>& points);

/// Warnings of surfaces that cut cells of soil at rest on them, where the linear basis has the
/// stresses of a cell from the few points in it. Empty: no surface does, or the soil is not at
/// rest.
/// @note Collective.
template <int dim>
std::vector<std::string> cut_cells_texts(MPI_Comm comm, const MpmSettings<dim>& settings,
                                         const std::vector<StartSurface<dim>>& surfaces,
                                         const BackgroundGrid<dim>& grid,
                                         const MaterialPoints<dim>& points);

}  // namespace gabion::mpm
