// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "mpm_solver/grid/basis.hpp"
#include "mpm_solver/grid/grid_nodes.hpp"
#include "mpm_solver/points/material_points.hpp"

namespace gabion::mpm {

/// The inertia of the material points as it acts at the nodes: an impulse I_i of a node goes to its
/// points by their share of its mass, and their velocities are mapped back,
///
///     dv_p = sum_i rho_ip I_i / m_p ,  dv_i = sum_p rho_ip dv_p = sum_j W_ij I_j ,
///     rho_ip = N_ip m_p / m_i ,  sum_p rho_ip = 1
///
/// so FLIP gives the points exactly the kinetic energy that the forces gave the nodes. W is
/// symmetric, W <= diag(1 / m_i), and bounded by 1 / m_p however small m_i is: a node that its
/// points hardly weigh on moves with them instead of flying away. The shares of a node without any
/// weight are those of the masses of the points of its cells. Refers to its arguments.
/// @see Sulsky, Zhou, Schreyer (1995): velocities mapped back before strains are taken
template <int dim>
class PointInertia {
 public:
  /// @pre nodes have their mass. @note Collective.
  PointInertia(const MaterialPoints<dim>& points, const PointWeights<dim>& weights,
               const GridNodes<dim>& nodes);

  /// dv = W I; cells where I is zero are passed over.
  /// @param impulse, dv  num_nodes x dim [N s], [m/s]. @note Collective.
  void apply(std::span<const double> impulse, std::span<double> dv) const;
  /// Responses of some groups alone.
  /// @param groups  ascending
  void apply_to(std::span<const std::int32_t> groups, std::span<const double> impulse,
                std::span<double> dv) const;

  /// Add W to the values of a matrix by rows that has a place for each pair of nodes of a group,
  /// columns ascending. @pre one rank
  void add_rows(std::span<const std::int32_t> starts, std::span<const std::int32_t> columns,
                std::span<double> values) const;

  /// Bound of the largest eigenvalue of W K [1/s^2], from the row sums of |K|: a norm of W K.
  /// @param row_sums  num_nodes [N/m]. @note Collective.
  double largest_rate(std::span<const double> row_sums) const;

  /// Give the points the impulses of nodes without weight, which mapping them by N would lose.
  /// @param share  that reaches the points. @note Not collective.
  void kick_from_weightless(std::span<const double> impulse, double share,
                            MaterialPoints<dim>& points) const;
  bool is_weightless(std::int32_t node) const { return nodes_.m[node] <= weightless_; }

 private:
  void add_responses(const CellGroup& group, std::span<const double> impulse,
                     std::span<double> dv) const;
  const double* rho_of(const CellGroup& group) const {
    return rho_.data() + weights_.starts[group.first];
  }

  const MaterialPoints<dim>& points_;
  const PointWeights<dim>& weights_;
  const GridNodes<dim>& nodes_;
  double weightless_ = 0;        // a node of this mass or less is [kg]
  bool any_weightless_ = false;  // on this rank
  std::vector<double> rho_;      // of each value of the weights
};

}  // namespace gabion::mpm
