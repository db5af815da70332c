// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

#include "mpm_solver/grid/basis.hpp"

namespace gabion::mpm {

/// Number of nodes of PointWeights::whole_cells that are no simplices.
template <int dim>
inline constexpr int num_brick_nodes = dim == 2 ? 4 : 8;

/// The nodes that act on an entry of PointWeights.
/// @tparam num_nodes  where all nodes act on all points (PointWeights::whole_cells): their number;
///                    otherwise 0
template <int dim, int num_nodes>
struct EntryValues {
  int n;
  const double* N;            ///< of each
  const Vector<dim>* grad;    ///< of each
  const std::uint8_t* local;  ///< each one's number in the group; null in whole cells

  EntryValues(const PointWeights<dim>& weights, std::int32_t entry) {
    if constexpr (num_nodes > 0) {
      const std::ptrdiff_t first = std::ptrdiff_t{entry} * num_nodes;
      n = num_nodes;
      N = weights.N.data() + first;
      grad = weights.grad_N.data() + first;
      local = nullptr;
    } else {
      n = weights.num_nodes(entry);
      N = weights.N_of(entry);
      grad = weights.grad_of(entry);
      local = weights.local_of(entry);
    }
  }
  int size() const { return num_nodes > 0 ? num_nodes : n; }
  int number(int i) const { return num_nodes > 0 ? i : local[i]; }
};

/// Call act.operator()<num_nodes>() with the number of EntryValues.
template <int dim, class Act>
void with_num_nodes(const PointWeights<dim>& weights, const Act& act) {
  if (weights.whole_cells && !weights.constant_gradient) {
    act.template operator()<num_brick_nodes<dim>>();
  } else {
    act.template operator()<0>();
  }
}

}  // namespace gabion::mpm
