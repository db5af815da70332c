// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/LU>

#include "common/mechanics/petsc/block_ilu.hpp"
#include "tests/unit/petsc/random_system.hpp"

namespace gabion::test_block_ilu {
namespace {

using test::assembled;
using test::random_system;

template <int block_size>
Eigen::MatrixXd dense_of(const BlockMatrix<block_size>& K, const std::vector<double>& values) {
  Eigen::MatrixXd dense =
      Eigen::MatrixXd::Zero(K.num_nodes() * block_size, K.num_nodes() * block_size);
  for (std::int32_t i = 0; i < K.num_nodes(); ++i) {
    for (std::int32_t s = K.row_starts()[i]; s < K.row_starts()[i + 1]; ++s) {
      dense.block<block_size, block_size>(i * block_size, K.columns()[s] * block_size) =
          Eigen::Map<const NodeBlock<block_size>>(values.data() + s * block_size * block_size);
    }
  }
  return dense;
}

/// Algorithm 10.4 of Saad (2003) entry by entry of a dense matrix of blocks, in place.
template <int block_size>
void eliminate(Eigen::MatrixXd& A, const Eigen::MatrixXi& has) {
  constexpr int n = block_size;
  const auto num_nodes = static_cast<int>(has.rows());
  for (int i = 1; i < num_nodes; ++i) {
    for (int k = 0; k < i; ++k) {
      if (has(i, k) == 0) continue;
      const Eigen::MatrixXd L = A.block(i * n, k * n, n, n) * A.block(k * n, k * n, n, n).inverse();
      A.block(i * n, k * n, n, n) = L;
      for (int j = k + 1; j < num_nodes; ++j) {
        if (has(i, j) != 0) A.block(i * n, j * n, n, n) -= L * A.block(k * n, j * n, n, n);
      }
    }
  }
}

template <int block_size>
void expect_factors_of_the_pattern() {
  SCOPED_TRACE(block_size);
  const auto system = random_system<block_size>(23, 30, 3, 0.3, 7);
  const BlockMatrix<block_size> K = assembled(system);
  const std::vector<double> values(K.values().begin(), K.values().end());
  Eigen::MatrixXi has = Eigen::MatrixXi::Zero(K.num_nodes(), K.num_nodes());
  for (std::int32_t i = 0; i < K.num_nodes(); ++i) {
    for (std::int32_t s = K.row_starts()[i]; s < K.row_starts()[i + 1]; ++s)
      has(i, K.columns()[s]) = 1;
  }
  ASSERT_LT(has.sum(), has.size());  // there would be fill
  Eigen::MatrixXd factors = dense_of(K, values);
  eliminate<block_size>(factors, has);
  // L has ones on its diagonal blocks, U the rest.
  Eigen::MatrixXd L = Eigen::MatrixXd::Identity(factors.rows(), factors.cols()), U = factors;
  for (int i = 0; i < K.num_nodes(); ++i) {
    for (int k = 0; k < i; ++k) {
      L.block<block_size, block_size>(i * block_size, k * block_size) =
          factors.block<block_size, block_size>(i * block_size, k * block_size);
      U.block<block_size, block_size>(i * block_size, k * block_size).setZero();
    }
  }
  const Eigen::VectorXd expected = Eigen::VectorXd::Random(factors.rows());
  Eigen::VectorXd x = L * (U * expected);
  BlockIlu<block_size>(K, values).solve({x.data(), static_cast<std::size_t>(x.size())});
  EXPECT_LT((x - expected).norm(), 1e-12 * expected.norm());
}

TEST(BlockIlu, factors_have_the_pattern_of_the_matrix) {
  expect_factors_of_the_pattern<2>();
  expect_factors_of_the_pattern<3>();
}

/// Where elimination makes no fill the factors are those of the matrix itself.
TEST(BlockIlu, a_chain_is_solved_exactly) {
  std::vector<std::int32_t> offsets{0}, nodes;
  for (std::int32_t i = 0; i + 1 < 12; ++i) {
    nodes.insert(nodes.end(), {i, i + 1});
    offsets.push_back(static_cast<std::int32_t>(nodes.size()));
  }
  BlockMatrix<3> K;
  K.set_pattern(12, offsets, nodes);
  for (std::int32_t i = 0; i < 12; ++i) {
    K.add_block(i, i, 5 * NodeBlock<3>::Identity() + NodeBlock<3>::Random());
    if (i > 0) K.add_block(i, i - 1, NodeBlock<3>::Random());
    if (i > 0) K.add_block(i - 1, i, NodeBlock<3>::Random());
  }
  const std::vector<double> values(K.values().begin(), K.values().end());
  Eigen::VectorXd x = Eigen::VectorXd::Random(36);
  const Eigen::VectorXd expected = dense_of(K, values).partialPivLu().solve(x);
  BlockIlu<3>(K, values).solve({x.data(), 36});
  EXPECT_LT((x - expected).norm(), 1e-12 * expected.norm());
}

}  // namespace
}  // namespace gabion::test_block_ilu
