// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstring>
#include <limits>
#include <span>
#include <vector>

#include "mpm_solver/stress/point_motion.hpp"

namespace gabion::mpm {

/// The largest surplus_motion of this rank's points, for the solutions of one step. Groups whose
/// nodes move as in the solution before are not looked at again.
template <int dim>
class SurplusMotions {
 public:
  /// Forget the solution before: a step begins.
  void forget() { du_.clear(); }
  /// Less than 0: no point has one [m].
  double largest(const PointsInStep<dim>& step) {
    const auto& groups = step.weights.groups;
    const bool known = !du_.empty();
    of_group_.resize(groups.size());
    double largest = -std::numeric_limits<double>::infinity();
    for (std::size_t g = 0; g < groups.size(); ++g) {
      if (!known || moves_otherwise(step, groups[g]))
        of_group_[g] = surplus_motion(step, groups[g]);
      largest = std::max(largest, of_group_[g]);
    }
    du_.assign(step.du.begin(), step.du.end());
    return largest;
  }

 private:
  bool moves_otherwise(const PointsInStep<dim>& step, const CellGroup& group) const {
    const std::int32_t* const first = step.nodes.of_groups.data() + group.first_node;
    return std::any_of(first, first + group.num_nodes, [&](std::int32_t i) {
      const std::ptrdiff_t k = std::ptrdiff_t{i} * dim;
      return std::memcmp(&du_[k], &step.du[k], dim * sizeof(double)) != 0;
    });
  }

  std::vector<double> du_;        // of the solution before; empty: there was none
  std::vector<double> of_group_;  // largest of its points [m]
};

}  // namespace gabion::mpm
