// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <span>
#include <vector>

#include "common/mechanics/elements/shape_functions.hpp"
#include "fem_solver/materials/green_stress.hpp"

namespace gabion::fem {

/// Number of enhancing modes alpha of quad4 and hex8.
template <int dim>
inline constexpr int num_modes = dim == 2 ? 4 : 9;

/// Enhancement of the strain at a point by each mode, without dimension.
template <int dim>
using ModeStrains = Eigen::Matrix<double, strain_size<dim>, num_modes<dim>>;

/// Derivative of the strain by the displacements of the nodes.
template <int dim, int num_dofs>
using StrainByNodes = Eigen::Matrix<double, strain_size<dim>, num_dofs>;

/// Modes at the points of a rule in a quad4 or hex8 (Simo and Rifai 1990): their mean over the cell
/// is zero, so that uniform stresses do not see them (docs/theory/structure.md, (T16)).
/// @param x_nodes  of the cell, 2^dim
template <int dim>
std::vector<ModeStrains<dim>> enhancing_modes(std::span<const Vector<dim>> x_nodes,
                                              std::span<const QuadraturePoint<dim>> rule);

}  // namespace gabion::fem
