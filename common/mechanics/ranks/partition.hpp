// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <cstdint>
#include <span>
#include <vector>

#include "common/mechanics/tensor.hpp"

namespace gabion {

/// A plane across one axis.
struct AxisPlane {
  int axis = 0;
  double position = 0;  ///< [m]
};

/// A partition of space into as many parts as there are ranks: a tree of planes that every rank
/// holds. The root parts the lower half of the ranks from the upper one, and so on.
template <int dim>
class Partition {
 public:
  /// All of space is the only part.
  Partition() = default;
  /// @param planes  planes[k] is the one between ranks k and k + 1: where a part of the tree has
  ///                ranks first .. last - 1, the middle one of its planes parts it
  explicit Partition(std::vector<AxisPlane> planes) : planes_(std::move(planes)) {}

  int num_parts() const { return static_cast<int>(planes_.size()) + 1; }
  const std::vector<AxisPlane>& planes() const { return planes_; }

  /// Ranks first .. last - 1 of a part of the tree that the plane `plane()` parts.
  struct Range {
    int first = 0, last = 1;
    int middle() const { return first + (last - first) / 2; }
    int plane() const { return middle() - 1; }
    bool is_parted() const { return last - first > 1; }
    Range below() const { return {first, middle()}; }
    Range above() const { return {middle(), last}; }
  };
  /// The part that a place lies in; a plane belongs to what is above it.
  int rank_of(const Vector<dim>& x) const {
    Range range{0, num_parts()};
    while (range.is_parted()) {
      const AxisPlane& plane = planes_[range.plane()];
      range = x[plane.axis] < plane.position ? range.below() : range.above();
    }
    return range.first;
  }

 private:
  std::vector<AxisPlane> planes_;
};

/// Recursive coordinate bisection: each plane lies across the longest side of the box around the
/// places of its part and leaves as many of them on either side as there are ranks, as nearly as
/// their coordinates allow. Depends on all places together, not on which rank has which.
/// @param places  of this rank [m]
/// @see Berger and Bokhari (1987)
/// @note Collective: a few sums over the ranks for each level of the tree.
template <int dim>
Partition<dim> bisect(MPI_Comm comm, int num_parts, std::span<const Vector<dim>> places);

}  // namespace gabion
