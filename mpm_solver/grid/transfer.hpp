// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "common/mechanics/time_integration/newmark.hpp"
#include "mpm_solver/grid/basis.hpp"
#include "mpm_solver/grid/grid_nodes.hpp"
#include "mpm_solver/points/material_points.hpp"

namespace gabion::mpm {

/// Map mass, velocity and acceleration of the material points to the active nodes (P2G).
///
///     m_i = sum_p N_ip m_p ,  v_i = sum_p N_ip m_p v_p / m_i ,  a_i likewise
///
/// Where the points carry gradients (TPIC), v_p is continued to the node: v_p + grad v_p (x_i -
/// x_p), a_p likewise.
///
/// A node that no point weighs on (m_i = 0 to rounding: a point on the opposite face of its cell)
/// takes the mean velocity and acceleration of the points of its cells.
/// @note Collective.
template <int dim>
void points_to_grid(const MaterialPoints<dim>& points, const PointWeights<dim>& weights,
                    GridNodes<dim>& nodes);

/// Mass of a node [kg] up to which its mapped velocity would be a quotient of rounding errors.
/// @note Collective.
template <int dim>
double weightless_mass(const GridNodes<dim>& nodes);

/// Nodal forces of an acceleration of each material point, f_i = sum_p N_ip m_p b_p.
/// @param b  [m/s^2], num_points
/// @returns  num_nodes x dim [N]
/// @note Collective.
template <int dim>
std::vector<double> point_forces(const MaterialPoints<dim>& points,
                                 const PointWeights<dim>& weights, const GridNodes<dim>& nodes,
                                 std::span<const Vector<dim>> b);

/// Motion of the active nodes in one step.
template <int dim>
struct NodalMotion {
  std::vector<Vector<dim>> du;     ///< displacement increment [m]
  std::vector<Vector<dim>> v_new;  ///< velocity at the end of the step [m/s]
  std::vector<Vector<dim>> a_new;  ///< acceleration at the end of the step [m/s^2]
};

/// Move the material points with the grid (G2P):
///
///     x += sum_i N_i du_i ,  v += sum_i N_i (v'_i - v_i) ,  a = sum_i N_i a'_i
///
/// v_i is the velocity mapped from the points, after InelasticProjection; with TPIC before the
/// walls act, so that their impulse reaches the points. The velocity is then blended with eta parts
/// of sum_i N_i v'_i (PIC).
///
/// Where the points carry gradients (TPIC, with eta = 1), those of the new positions replace them,
///
///     grad v = [sum_i v'_i (x) grad N_i] (1 + H)^-1 ,  H = sum_i du_i (x) grad N_i ,  grad a
///     likewise
///
/// so that the velocity of a rigid rotation, of any angle in the step, is kept.
/// @param pic_share  eta, 0 = FLIP, 1 = PIC
/// @see Brackbill and Ruppel (1986) for FLIP; Nakamura, Matsumura, Mizutani (2023) for TPIC
template <int dim>
void grid_to_points(const GridNodes<dim>& nodes, const NodalMotion<dim>& motion,
                    const PointWeights<dim>& weights, double pic_share,
                    MaterialPoints<dim>& points);

}  // namespace gabion::mpm
