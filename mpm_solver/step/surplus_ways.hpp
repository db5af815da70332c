// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstring>
#include <limits>
#include <span>
#include <vector>

#include "mpm_solver/stress/point_motion.hpp"

namespace gabion::mpm {

/// Surplus ways of the solutions of one step. Groups whose nodes move as in the solution before
/// are not looked at again.
template <int dim>
class SurplusWays {
 public:
  /// A step begins.
  void forget() { du_.clear(); }
  /// See largest_surplus_way. @param du  num_nodes x dim [m]
  double largest(const MaterialPoints<dim>& points, const PointWeights<dim>& weights,
                 const GridNodes<dim>& nodes, std::span<const double> du, double dt) {
    const auto& groups = weights.groups;
    const bool known = du_.size() == du.size() && of_group_.size() == groups.size();
    of_group_.resize(groups.size());
    double largest = -std::numeric_limits<double>::infinity();
    for (std::size_t g = 0; g < groups.size(); ++g) {
      if (!known || moves_otherwise(nodes, groups[g], du)) {
        of_group_[g] = surplus_way(points, weights, nodes, groups[g], du, dt);
      }
      largest = std::max(largest, of_group_[g]);
    }
    du_.assign(du.begin(), du.end());
    return largest;
  }

 private:
  bool moves_otherwise(const GridNodes<dim>& nodes, const CellGroup& group,
                       std::span<const double> du) const {
    const std::int32_t* const first = nodes.of_groups.data() + group.first_node;
    return std::any_of(first, first + group.num_nodes, [&](std::int32_t i) {
      const std::ptrdiff_t k = std::ptrdiff_t{i} * dim;
      return std::memcmp(&du_[k], &du[k], dim * sizeof(double)) != 0;
    });
  }

  std::vector<double> du_;        // of the solution before; empty: there was none
  std::vector<double> of_group_;  // largest of its points [m]
};

}  // namespace gabion::mpm
