// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "common/mechanics/tensor.hpp"

namespace gabion::mpm {

/// Says once that boulders pressed on a structure for a few steps only: it gets the mean force of
/// each step, so that the peak of a short impact depends on the step.
class ImpactWatch {
 public:
  /// Call for each interface in each accepted step.
  /// @param forces  mean forces of the boulders on its vertices [N]
  /// @param dt      the step [s]
  void look_at(std::size_t interface, const std::string& name, std::span<const Vector<3>> forces,
               double dt);

 private:
  std::vector<int> steps_;  // in which boulders have pressed on each interface so far
  bool has_warned_ = false;
};

}  // namespace gabion::mpm
