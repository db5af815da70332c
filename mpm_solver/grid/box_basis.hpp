// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "mpm_solver/grid/basis.hpp"

namespace gabion::mpm {

/// Evaluate gimp or bspline at the material points: the part of `evaluate_basis` that follows the
/// sorting of the points by cell.
/// @param[in]     grid     with a BoxGrid
/// @param[in,out] weights  `point` and `groups` as sorted; the rest is filled
template <int dim>
void evaluate_box_basis(const BackgroundGrid<dim>& grid, const MaterialPoints<dim>& points,
                        PointWeights<dim>& weights);

/// Half lengths of the domain of a point by the spacing, cut to one cell.
template <int dim>
Vector<dim> gimp_domain(const BoxGrid<dim>& box, const MaterialPoints<dim>& points, std::int32_t p);

/// Part of the domain of a point, of which `share` lies in a cell.
struct DomainPart {
  std::int32_t cell;
  double share;
};

/// The cells that the domain of a point reaches into, its own one first; shares add up to one.
template <int dim>
std::vector<DomainPart> cells_of_domain(const BoxGrid<dim>& box, const MaterialPoints<dim>& points,
                                        std::int32_t p);

}  // namespace gabion::mpm
