// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "common/mechanics/petsc/block_matrix.hpp"
#include "mpm_solver/stress/stress_parts.hpp"

namespace gabion::mpm {

/// The material points of one rank that yielded in any trial state since the solution began. Their
/// stress has kinks, at the apex between full stiffness and none, where Newton's method may need
/// regularisation (NewtonProblem::regularise).
template <int dim>
class YieldingPoints {
 public:
  /// Forget the points: a new solution begins.
  void forget() { yielded_.clear(); }
  /// Note the points that yielded in an evaluation of the stresses. @param region  of each entry of
  /// PointWeights
  void add(const std::vector<YieldRegion>& region);
  bool any() const;
  /// Add `share` of the elastic stiffness of these points to K, at small strain.
  void add_stiffness(double share, const StressParts<dim>& parts, BlockMatrix<dim>& K) const;

 private:
  std::vector<std::uint8_t> yielded_;  // 1 or 0 of each entry; empty: nothing was evaluated
};

}  // namespace gabion::mpm
