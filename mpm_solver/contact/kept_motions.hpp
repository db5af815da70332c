// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "common/mechanics/tensor.hpp"

namespace gabion::mpm {

/// Displacements of nodes that the last solution of a step had: of all nodes, or of those that a
/// contact asks for.
template <int dim>
class KeptMotions {
 public:
  /// Keep those of these nodes from now on. @param nodes  ascending, each once; none: all
  void keep_at(std::vector<std::int32_t> nodes) { nodes_ = std::move(nodes); }
  /// @param du  of all nodes, nodes x dim [m]
  void set(std::span<const double> du) {
    if (nodes_.empty()) {
      du_.assign(du.begin(), du.end());
      return;
    }
    du_.clear();
    for (const std::ptrdiff_t node : nodes_) {
      du_.insert(du_.end(), du.begin() + node * dim, du.begin() + (node + 1) * dim);
    }
  }
  void clear() { du_.clear(); }
  bool empty() const { return du_.empty(); }
  /// @pre the node is one of those that are kept
  Vector<dim> at(std::int32_t node) const {
    std::ptrdiff_t place = node;
    if (!nodes_.empty()) place = std::ranges::lower_bound(nodes_, node) - nodes_.begin();
    return Eigen::Map<const Vector<dim>>(du_.data() + place * dim);
  }

 private:
  std::vector<std::int32_t> nodes_;
  std::vector<double> du_;
};

}  // namespace gabion::mpm
