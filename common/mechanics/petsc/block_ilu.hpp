// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/mechanics/petsc/block_matrix.hpp"

namespace gabion {

/// Incomplete factors L U of a BlockMatrix in its own pattern: no fill, no exchange of rows.
/// @see Saad, Iterative Methods for Sparse Linear Systems (2003), algorithm 10.4, with blocks
template <int block_size>
class BlockIlu {
 public:
  /// @param pattern  must outlive this
  /// @param values   as those of `pattern`. A pivot that is singular makes solutions that are not
  ///                 finite.
  BlockIlu(const BlockMatrix<block_size>& pattern, std::vector<double> values);

  /// L U x = b in place. @param x  num_nodes x block_size, at first b
  void solve(std::span<double> x) const;

  double bytes() const { return static_cast<double>(values_.capacity() * sizeof(double)); }

 private:
  using Block = Eigen::Map<NodeBlock<block_size>>;
  Block block(std::int32_t s) {
    return Block(values_.data() + static_cast<std::size_t>(s) * block_size * block_size);
  }
  void factorise();
  void eliminate(std::int32_t i, std::vector<std::int32_t>& slot_of);

  const BlockMatrix<block_size>& pattern_;
  std::vector<double> values_;  // L below the diagonal, its inverse on it, U above
};

}  // namespace gabion
