// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <limits>

#include "mpm_solver/grid/fastest_about.hpp"
#include "mpm_solver/stress/stress_parts.hpp"

namespace gabion::mpm {

/// Displacement of a point in the step, sum_i N_ip du_i [m].
/// @param du  of the group's nodes [m], dim each
template <int dim>
Vector<dim> point_displacement(const PointWeights<dim>& weights, std::int32_t entry,
                               const double* du) {
  const double* N = weights.N_of(entry);
  const std::uint8_t* local = weights.local_of(entry);
  Vector<dim> sum = Vector<dim>::Zero();
  for (int i = 0; i < weights.num_nodes(entry); ++i) {
    sum += N[i] * Eigen::Map<const Vector<dim>>(du + local[i] * dim);
  }
  return sum;
}

/// Largest displacement of a point of this rank in the step [m].
template <int dim>
double largest_displacement(const PointWeights<dim>& weights, const GridNodes<dim>& nodes,
                            std::span<const double> du) {
  double largest = 0;
  GroupDisplacements<dim> of_group;
  for (const CellGroup& group : weights.groups) {
    nodes.gather(weights.nodes_of(group), du, of_group.data());
    for (std::int32_t e = group.first; e < group.last; ++e) {
      largest = std::max(largest, point_displacement(weights, e, of_group.data()).norm());
    }
  }
  return largest;
}

/// Motion of the points of this rank in a step.
template <int dim>
struct PointsInStep {
  const MaterialPoints<dim>& points;
  const PointWeights<dim>& weights;
  const GridNodes<dim>& nodes;
  std::span<const double> du;  ///< num_nodes x dim [m]
  double dt;                   ///< [s]
};

/// Largest excess of the displacement of a point of a group over twice that by the velocity of
/// fastest_about [m]; below 0: no point moves so far.
template <int dim>
double surplus_motion(const PointsInStep<dim>& step, const CellGroup& group) {
  const auto& [points, weights, nodes, du, dt] = step;
  double largest = -std::numeric_limits<double>::infinity();
  GroupDisplacements<dim> of_group;
  nodes.gather(weights.nodes_of(group), du, of_group.data());
  for (std::int32_t e = group.first; e < group.last; ++e) {
    largest = std::max(largest, point_displacement(weights, e, of_group.data()).norm() -
                                    2 * dt * fastest_about(points, weights, nodes, group, e));
  }
  return largest;
}

/// The entry of PointWeights whose point a step strains most, of this rank.
struct MostStrained {
  std::int32_t entry = -1;  ///< -1: this rank has no points
  double strain = 0;        ///< |E|, E = (H + H^T + H^T H) / 2: rotation does not count
};

/// @param du  displacement increment of the active nodes [m], num_nodes x dim
template <int dim>
MostStrained most_strained(const PointWeights<dim>& weights, const GridNodes<dim>& nodes,
                           std::span<const double> du) {
  MostStrained worst;
  GroupDisplacements<dim> of_group;
  for (const CellGroup& group : weights.groups) {
    nodes.gather(weights.nodes_of(group), du, of_group.data());
    // One gradient holds for the whole group, and stands at its first entry.
    const std::int32_t last = weights.constant_gradient ? group.first + 1 : group.last;
    for (std::int32_t e = group.first; e < last; ++e) {
      const Matrix<dim> H = displacement_gradient(weights, e, of_group.data());
      const double strain = (0.5 * (H + H.transpose() + H.transpose() * H)).norm();
      if (worst.entry >= 0 && !(strain > worst.strain)) continue;
      worst = {e, strain};
    }
  }
  return worst;
}

}  // namespace gabion::mpm
