// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "mpm_solver/contact/contact_settings.hpp"
#include "mpm_solver/grid/basis.hpp"
#include "mpm_solver/points/pool.hpp"

namespace gabion::mpm {

/// Integral of the pressure of pools over a segment (2D) or triangle (3D) by its corners' linear
/// functions: exact, wherever the level cuts it.
/// @returns of each corner [N], 2D per metre of thickness
template <int dim>
std::array<double, dim> pool_pressure_on(const PoolLevels& pools,
                                         const std::array<Vector<dim>, dim>& corners);

/// Forces of pools on the front of all facets of a surface, num_vertices x dim [N].
/// @param displacement  of the vertices, num_vertices x dim [m]
template <int dim>
std::vector<double> pool_forces(const PoolLevels& pools, const ContactSurface<dim>& surface,
                                std::span<const double> displacement);

/// Force of pools on sides of the grid, a box, outwards [N].
/// @param facets  nodes of facets of its sides, one facet after the other
template <int dim>
Vector<dim> pool_force_on_sides(const PoolLevels& pools, const BoxGrid<dim>& box,
                                std::span<const std::int32_t> facets);

}  // namespace gabion::mpm
