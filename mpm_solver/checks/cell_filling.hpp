// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "mpm_solver/grid/background_grid.hpp"
#include "mpm_solver/points/material_points.hpp"

namespace gabion::mpm {

/// Cells count as evenly filled where the volumes of their points add up to theirs within this
/// share.
inline constexpr double even_filling = 0.01;

/// Largest difference between the volume of the points in a cell and that of the cell, over the
/// latter, among cells inside the soil: cells around whose nodes all cells are filled by
/// `least_filling`. The result is 0 where the meshes of the bodies fit the cells of the grid, and
/// where no cell is inside. Points outside the grid do not count.
/// @param layouts  bodies as they will be laid
template <int dim>
double uneven_filling(const BackgroundGrid<dim>& grid,
                      const std::vector<PointLayout<dim>>& layouts);

}  // namespace gabion::mpm
