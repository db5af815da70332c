// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "mpm_solver/grid/grid_nodes.hpp"
#include "mpm_solver/points/material_points.hpp"
#include "mpm_solver/walls/wall_conditions.hpp"

namespace gabion::mpm {

/// Walls stop the soil at the start of a step: impulses J of the held nodes, after which the points
/// have there what they would have if they moved with the nodes, s, but no more than before,
///
///     (1 - Q) (v + W J) = w / dt + min(1, |u| / |s|) s ,  J = (1 - Q) J ,
///     u = (1 - Q) v - w / dt ,  s = (1 - Q) S (Q v + w / dt) - w / dt ,
///     dv_p = sum_i rho_ip J_i / m_p ,  rho_ip = N_ip m_p / m_i ,
///     W_ij = sum_p rho_ip rho_jp / m_p ,  S_ij = sum_p rho_ip N_jp
///
/// with Q and w of WallConditions. This is the plastic impact of the points: of all changes of
/// their velocities that meet the condition it takes the least kinetic energy. The mapped v of soil
/// that shears over a wall is not zero there, S tells which part of it is no motion through the
/// wall. Stopping the nodes instead, m_i (Q v_i - v_i), would brake such soil in each step anew.
/// Where the points lag behind the nodes, s alone would push them; a wall at rest gives no energy.
/// A gain that remains because W couples the nodes is removed by a factor of J.
///
/// J is found by `num_sweeps` Chebyshev iterations for eigenvalues of m W from `least` to 1, its
/// upper bound: a fixed linear map, which needs no sums over all nodes. It leaves 0.04 of a mode at
/// `least`; nodes on which points hardly weigh follow in later steps, nodes without weight are left
/// out.
/// @see Golub and Varga (1961) for Chebyshev's method
template <int dim>
class InelasticProjection {
 public:
  static constexpr int num_sweeps = 10;
  static constexpr double least = 0.04;

  /// Stop the points; nodes.v becomes the velocity mapped from them after that, at the held nodes
  /// that of the walls.
  /// @param nodes  with the walls' nodes selected. @note Collective.
  void find(const MaterialPoints<dim>& points, const PointWeights<dim>& weights,
            const WallConditions<dim>& walls, double dt, GridNodes<dim>& nodes);
  /// Forget the impulses: nothing is stopped in this step.
  void forget();

  /// Give the points the impulses that `find` gave the nodes.
  void kick(const PointWeights<dim>& weights, MaterialPoints<dim>& points) const;
  bool acts() const { return acts_; }                        ///< on any rank
  const std::vector<double>& impulse() const { return J_; }  ///< num_nodes x dim [N s]; @pre acts
  /// Sums over all ranks.
  struct Totals {
    double loss = 0;                            ///< kinetic energy of the points [J]
    double work = 0;                            ///< of walls that move, on the points [J]
    Vector<dim> impulse = Vector<dim>::Zero();  ///< on the points [N s]
    /// Momentum of the nodes that the points do not get [N s].
    Vector<dim> of_nodes = Vector<dim>::Zero();
  };
  const Totals& totals() const { return totals_; }

 private:
  /// A point that weighs on held nodes, with its values at them.
  struct WallPoint {
    std::int32_t group;
    std::int32_t entry;
    std::int32_t last_value;  // one past them
    double m;                 // [kg]
    Vector<dim> dv;           // [m/s]
  };
  struct Value {
    std::int32_t node;
    double rho;
  };
  void list_points(const MaterialPoints<dim>& points, const PointWeights<dim>& weights,
                   const WallConditions<dim>& walls, const GridNodes<dim>& nodes);
  void search(const WallConditions<dim>& walls, const GridNodes<dim>& nodes, std::vector<double> r);
  void limit(const WallConditions<dim>& walls, std::span<const double> u,
             std::vector<double>& r) const;
  double avoid_gain(const SharedNodes& shared, std::span<const double> u, std::vector<double>& W_J);
  void respond(const SharedNodes& shared, std::span<const double> impulse, std::span<double> dv);
  std::vector<double> smooth(const PointWeights<dim>& weights, const GridNodes<dim>& nodes,
                             std::span<const double> v) const;
  void move_nodes(const PointWeights<dim>& weights, GridNodes<dim>& nodes) const;

  double weightless_ = 0;  // a node of this mass or less is [kg]
  bool acts_ = false;
  std::vector<WallPoint> at_walls_;  // of this rank
  std::vector<Value> values_;
  std::vector<double> J_;
  Totals totals_;
};

}  // namespace gabion::mpm
