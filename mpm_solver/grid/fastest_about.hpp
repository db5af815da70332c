// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "mpm_solver/grid/grid_nodes.hpp"

namespace gabion::mpm {

/// Largest speed of a point and of its nodes at the start of the step [m/s].
template <int dim>
double fastest_about(const MaterialPoints<dim>& points, const PointWeights<dim>& weights,
                     const GridNodes<dim>& nodes, const CellGroup& group, std::int32_t entry) {
  double square = points.v[weights.point[entry]].squaredNorm();
  const auto numbers = std::span(nodes.of_groups)
                           .subspan(weights.nodes_of(group).first, weights.nodes_of(group).size());
  const std::uint8_t* local = weights.local_of(entry);
  for (int i = 0; i < weights.num_nodes(entry); ++i) {
    square = std::max(square, nodes.v[numbers[local[i]]].squaredNorm());
  }
  return std::sqrt(square);
}

}  // namespace gabion::mpm
