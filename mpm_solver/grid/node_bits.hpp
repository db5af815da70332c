// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <cstdint>
#include <map>
#include <span>

#include "common/mechanics/ranks/packet.hpp"
#include "common/mechanics/ranks/shared_nodes.hpp"
#include "mpm_solver/grid/sparse_list.hpp"

namespace gabion::mpm {

/// Set the bits of each node that any of the ranks which hold it has set.
/// @param ids            grid nodes, of which `shared` was made
/// @param[in,out] bits   of the grid nodes
/// @note Collective.
template <class Bits>
void join_bits(MPI_Comm comm, const SharedNodes& shared, std::span<const std::int32_t> ids,
               SparseList<Bits>& bits) {
  if (shared.alone()) return;
  Packets out;
  std::map<int, std::span<const std::int32_t>> lists;
  for (int n = 0; n < shared.num_neighbours(); ++n) {
    const int rank = shared.neighbour(n);
    lists[rank] = shared.shared_with(n);
    for (const std::int32_t i : lists[rank]) out[rank].put(Bits{bits[ids[i]]});
  }
  for (auto& [rank, packet] : send_packets(comm, out)) {
    for (const std::int32_t i : lists[rank]) bits.at(ids[i]) |= packet.template take<Bits>();
  }
}

}  // namespace gabion::mpm
