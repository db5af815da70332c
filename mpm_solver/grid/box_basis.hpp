// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "mpm_solver/grid/basis.hpp"

namespace gabion::mpm {

/// Evaluate gimp or bspline at the material points: the part of `evaluate_basis` that follows the
/// sorting of the points by cell.
/// @param[in]     grid     with a BoxGrid
/// @param[in,out] weights  `point` and `groups` as sorted; the rest is filled
template <int dim>
void evaluate_box_basis(const BackgroundGrid<dim>& grid, const MaterialPoints<dim>& points,
                        PointWeights<dim>& weights);

}  // namespace gabion::mpm
