// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "mpm_solver/grid/basis.hpp"

namespace gabion::mpm {

/// evaluate_basis for the linear basis where the grid has patches: the points of one body in one
/// patch form a group, and its nodes are those of the cells that hold them.
/// @pre  grid.patches is not empty
template <int dim>
void evaluate_patch_basis(const BackgroundGrid<dim>& grid, const MaterialPoints<dim>& points,
                          PointWeights<dim>& weights);

}  // namespace gabion::mpm
