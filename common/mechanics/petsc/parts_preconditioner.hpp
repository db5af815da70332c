// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

namespace gabion {

/// z = M^-1 r for a matrix of which each rank has a part. Vectors: of the nodes that this rank
/// owns.
class PartsPreconditioner {
 public:
  virtual ~PartsPreconditioner() = default;
  /// @note Collective.
  virtual void apply(std::span<const double> r, std::span<double> z) = 0;
  virtual double bytes() const = 0;  ///< on this rank
};

}  // namespace gabion
