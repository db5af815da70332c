// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>

#include "common/mechanics/tensor.hpp"

namespace gabion::fem {

/// Nodes of rotations, behind those of places. Their unknowns are rotations times a length [m], so
/// that their forces, moments over that length, are in newtons.
struct BeamNodes {
  std::span<const std::int32_t> rotation_nodes;  ///< of each place, -1: none; empty: no beams
  double length = 1;                             ///< [m]

  bool any() const { return !rotation_nodes.empty(); }
  /// @returns -1: the node has no rotation
  std::int32_t of(std::int32_t place) const { return any() ? rotation_nodes[place] : -1; }
};

/// Moment that nodal forces exert at a node of rotations [N m].
template <int dim>
Vector<3> moment_of(std::span<const double> f, std::int32_t rotation_node, double length) {
  const double* own = f.data() + static_cast<std::size_t>(rotation_node) * dim;
  if constexpr (dim == 2) return {0, 0, length * own[0]};
  return length * Vector<3>(own[0], own[1], own[2]);
}

}  // namespace gabion::fem
