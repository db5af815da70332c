// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/petsc/block_ilu.hpp"

#include <Eigen/LU>

#include "common/base/require.hpp"
#include "common/mechanics/petsc/block_multiply.hpp"

namespace gabion {

template <int block_size>
BlockIlu<block_size>::BlockIlu(const BlockMatrix<block_size>& pattern, std::vector<double> values)
    : pattern_(pattern), values_(std::move(values)) {
  require(values_.size() == pattern_.columns().size() * block_size * block_size,
          "BlockIlu: found {} values for {} blocks of {}", values_.size(),
          pattern_.columns().size(), block_size);
  factorise();
}

template <int block_size>
void BlockIlu<block_size>::factorise() {
  std::vector<std::int32_t> slot_of(pattern_.num_nodes(), -1);
  for (std::int32_t i = 0; i < pattern_.num_nodes(); ++i) eliminate(i, slot_of);
}

// @param slot_of  -1 for each node
template <int block_size>
void BlockIlu<block_size>::eliminate(std::int32_t i, std::vector<std::int32_t>& slot_of) {
  const auto columns = pattern_.columns(), starts = pattern_.row_starts(),
             diagonal = pattern_.diagonal();
  for (std::int32_t s = starts[i]; s < starts[i + 1]; ++s) slot_of[columns[s]] = s;
  for (std::int32_t s = starts[i]; s < diagonal[i]; ++s) {
    const std::int32_t k = columns[s];
    const NodeBlock<block_size> L = block(s) * block(diagonal[k]);
    block(s) = L;
    for (std::int32_t t = diagonal[k] + 1; t < starts[k + 1]; ++t) {
      const std::int32_t target = slot_of[columns[t]];
      if (target >= 0) block(target).noalias() -= L * block(t);
    }
  }
  block(diagonal[i]) = block(diagonal[i]).inverse().eval();
  for (std::int32_t s = starts[i]; s < starts[i + 1]; ++s) slot_of[columns[s]] = -1;
}

template <int block_size>
void BlockIlu<block_size>::solve(std::span<double> x) const {
  using NodeVector = Eigen::Matrix<double, block_size, 1>;
  const BlockRows A{pattern_.row_starts().data(), pattern_.columns().data(), values_.data()};
  const auto diagonal = pattern_.diagonal();
  const auto of_node = [&](std::int32_t i) {
    return Eigen::Map<NodeVector>(x.data() + static_cast<std::size_t>(i) * block_size);
  };
  NodeVector sum;
  for (std::int32_t i = 0; i < pattern_.num_nodes(); ++i) {
    multiply_row<block_size>(A, A.row_starts[i], diagonal[i], x.data(), sum.data());
    of_node(i) -= sum;
  }
  for (std::int32_t i = pattern_.num_nodes() - 1; i >= 0; --i) {
    multiply_row<block_size>(A, diagonal[i] + 1, A.row_starts[i + 1], x.data(), sum.data());
    const NodeVector rest = of_node(i) - sum;
    of_node(i) = Eigen::Map<const NodeBlock<block_size>>(
                     A.values + static_cast<std::size_t>(diagonal[i]) * block_size * block_size) *
                 rest;
  }
}

template class BlockIlu<2>;
template class BlockIlu<3>;
template class BlockIlu<4>;

}  // namespace gabion
