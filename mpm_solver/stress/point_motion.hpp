// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "mpm_solver/stress/point_stress.hpp"

namespace gabion::mpm {

/// Displacement of a point in the step, sum_i N_ip du_i [m].
/// @param active  active numbers of the group's nodes
/// @param du      increment of the active nodes [m], num_nodes x dim
template <int dim>
Vector<dim> point_displacement(const PointWeights<dim>& weights, std::int32_t entry,
                               const std::int32_t* active, std::span<const double> du) {
  const double* N = weights.N_of(entry);
  const std::uint8_t* local = weights.local_of(entry);
  Vector<dim> sum = Vector<dim>::Zero();
  for (int i = 0; i < weights.num_nodes(entry); ++i) {
    const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(active[local[i]]) * dim;
    sum += N[i] * Eigen::Map<const Vector<dim>>(du.data() + row);
  }
  return sum;
}

/// Largest displacement of a point of this rank in the step [m].
template <int dim>
double largest_displacement(const PointWeights<dim>& weights, const GridNodes<dim>& nodes,
                            std::span<const double> du) {
  double largest = 0;
  std::int32_t active[max_group_nodes<dim>];
  for (const CellGroup& group : weights.groups) {
    nodes.list_active(weights.nodes_of(group), active);
    for (std::int32_t e = group.first; e < group.last; ++e) {
      largest = std::max(largest, point_displacement(weights, e, active, du).norm());
    }
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
  std::int32_t active[max_group_nodes<dim>];
  for (const CellGroup& group : weights.groups) {
    nodes.list_active(weights.nodes_of(group), active);
    // One gradient holds for the whole group, and stands at its first entry.
    const std::int32_t last = weights.constant_gradient ? group.first + 1 : group.last;
    for (std::int32_t e = group.first; e < last; ++e) {
      const Matrix<dim> H = displacement_gradient(weights, e, active, du);
      const double strain = (0.5 * (H + H.transpose() + H.transpose() * H)).norm();
      if (worst.entry >= 0 && !(strain > worst.strain)) continue;
      worst = {e, strain};
    }
  }
  return worst;
}

}  // namespace gabion::mpm
