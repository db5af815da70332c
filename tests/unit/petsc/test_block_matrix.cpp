// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/expect_error.hpp"
#include "tests/unit/petsc/random_system.hpp"

namespace gabion::test_block_matrix {
namespace {

using test::assembled;
using test::random_system;
using test::to_dense;

constexpr double round_off = 1e-13;

template <int block_size>
void expect_equal_to_dense(int nodes_per_cell) {
  const auto system = random_system<block_size>(23, 17, nodes_per_cell, 0.3, 7);
  const auto K = assembled(system);
  EXPECT_LT((to_dense(K) - system.dense).norm(), round_off * system.dense.norm());
  const Eigen::VectorXd x = Eigen::VectorXd::Random(system.dense.cols());
  Eigen::VectorXd y(x.size());
  K.multiply({x.data(), static_cast<std::size_t>(x.size())},
             {y.data(), static_cast<std::size_t>(y.size())});
  EXPECT_LT((y - system.dense * x).norm(), round_off * system.dense.norm() * x.norm());
}

TEST(BlockMatrix, equals_dense_sum_of_cells) {
  for (const int nodes : {1, 2, 3, 4, 6, 9}) expect_equal_to_dense<2>(nodes);
  for (const int nodes : {1, 3, 4, 8, 10}) expect_equal_to_dense<3>(nodes);
}

TEST(BlockMatrix, pattern_is_sorted_complete_and_minimal) {
  // Triangles 0-1-2 and 2-1-3; node 4 belongs to no cell.
  const std::vector<std::int32_t> offsets{0, 3, 6}, nodes{0, 1, 2, 2, 1, 3};
  BlockMatrix<2> K;
  K.set_pattern(5, offsets, nodes);
  const std::vector<std::int32_t> rows(K.row_starts().begin(), K.row_starts().end());
  const std::vector<std::int32_t> columns(K.columns().begin(), K.columns().end());
  EXPECT_EQ(rows, (std::vector<std::int32_t>{0, 3, 7, 11, 14, 15}));
  EXPECT_EQ(columns, (std::vector<std::int32_t>{0, 1, 2, 0, 1, 2, 3, 0, 1, 2, 3, 1, 2, 3, 4}));
  EXPECT_EQ(K.values().size(), 15u * 4);
}

TEST(BlockMatrix, new_pattern_forgets_the_old) {
  const auto large = random_system<2>(40, 50, 4, 0.1, 1);
  const auto small = random_system<2>(11, 7, 3, 0.1, 2);
  auto K = assembled(large);
  const auto first_pattern = K.pattern_id();
  K.set_pattern(small.num_nodes, small.offsets, small.cell_nodes);
  EXPECT_NE(K.pattern_id(), first_pattern);
  EXPECT_EQ(to_dense(K).norm(), 0);
  small.assemble(K);
  EXPECT_LT((to_dense(K) - small.dense).norm(), round_off * small.dense.norm());
  K.set_zero();
  EXPECT_EQ(to_dense(K).norm(), 0);
}

TEST(BlockMatrix, single_blocks_and_diagonals) {
  const std::vector<std::int32_t> offsets{0, 2}, nodes{1, 0};
  BlockMatrix<2> K;
  K.set_pattern(2, offsets, nodes);
  NodeBlock<2> block;
  block << 1, 2, 3, 4;
  K.add_block(0, 1, block);
  K.add_block(0, 1, block);
  K.add_diagonal(1, 7);
  Eigen::Matrix4d expected = Eigen::Matrix4d::Zero();
  expected.block<2, 2>(0, 2) = 2 * block;
  expected.block<2, 2>(2, 2) = 7 * NodeBlock<2>::Identity();
  EXPECT_EQ(to_dense(K), expected);
}

/// Takes one direction of a node's unknowns away.
template <int block_size>
NodeBlock<block_size> projector(const Eigen::Matrix<double, block_size, 1>& direction) {
  const Eigen::Matrix<double, block_size, 1> n = direction.normalized();
  return NodeBlock<block_size>::Identity() - n * n.transpose();
}

template <int block_size>
void expect_projected(bool owned) {
  const auto system = random_system<block_size>(12, 9, 4, 0.3, 3);
  auto K = assembled(system);
  const std::vector<std::int32_t> constrained{3, 0, 7};
  using NodeVector = Eigen::Matrix<double, block_size, 1>;
  const std::vector<NodeBlock<block_size>> projectors{
      projector<block_size>(NodeVector::Random()), NodeBlock<block_size>::Zero(),
      projector<block_size>(NodeVector::Unit(block_size - 1))};
  Eigen::MatrixXd Q = Eigen::MatrixXd::Identity(system.dense.rows(), system.dense.cols());
  Eigen::MatrixXd scale = Eigen::MatrixXd::Zero(system.dense.rows(), system.dense.cols());
  for (std::size_t k = 0; k < constrained.size(); ++k) {
    const int at = constrained[k] * block_size;
    Q.template block<block_size, block_size>(at, at) = projectors[k];
    scale.template block<block_size, block_size>(at, at) =
        system.dense.template block<block_size, block_size>(at, at).diagonal().cwiseAbs().mean() *
        NodeBlock<block_size>::Identity();
  }
  Eigen::MatrixXd expected = Q * system.dense * Q;
  if (owned) expected += scale * (Eigen::MatrixXd::Identity(Q.rows(), Q.cols()) - Q);
  K.constrain(constrained, projectors, [&](std::int32_t) { return owned; });
  EXPECT_LT((to_dense(K) - expected).norm(), round_off * system.dense.norm());
}

TEST(BlockMatrix, constrain_is_qkq_plus_scaled_rest) {
  for (const bool owned : {true, false}) {
    expect_projected<2>(owned);
    expect_projected<3>(owned);
  }
}

TEST(BlockMatrix, constrained_empty_node_gets_scale_of_the_others) {
  const std::vector<std::int32_t> offsets{0, 1}, nodes{0};
  BlockMatrix<2> K;
  K.set_pattern(2, offsets, nodes);
  K.add_diagonal(0, 8);
  const std::vector<std::int32_t> constrained{1};
  const std::vector<NodeBlock<2>> projectors{NodeBlock<2>::Zero()};
  K.constrain(constrained, projectors, [](std::int32_t) { return true; });
  EXPECT_DOUBLE_EQ(to_dense(K)(2, 2), 4);
  EXPECT_DOUBLE_EQ(to_dense(K)(3, 3), 4);
}

TEST(BlockMatrix, constrain_refuses_lists_of_different_length) {
  const std::vector<std::int32_t> offsets{0, 1}, nodes{0};
  BlockMatrix<2> K;
  K.set_pattern(2, offsets, nodes);
  const std::vector<std::int32_t> constrained{1};
  test::expect_error<Error>(
      [&] { K.constrain(constrained, {}, [](std::int32_t) { return true; }); },
      {"BlockMatrix::constrain: 1 nodes, but 0 projectors"});
}

}  // namespace
}  // namespace gabion::test_block_matrix
