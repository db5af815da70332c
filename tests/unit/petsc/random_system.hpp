// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Dense>
#include <random>
#include <vector>

#include "common/mechanics/petsc/block_matrix.hpp"

namespace gabion::test {

/// Cells that share nodes at random, with a dense matrix each, and the dense sum of them.
template <int block_size>
struct RandomSystem {
  std::int32_t num_nodes = 0;
  std::vector<std::int32_t> offsets{0};
  std::vector<std::int32_t> cell_nodes;
  std::vector<std::vector<double>> cells;  // row-major
  Eigen::MatrixXd dense;

  int num_cells() const { return static_cast<int>(cells.size()); }

  /// Add those cells c with c % stride == first.
  void assemble(BlockMatrix<block_size>& K, int first = 0, int stride = 1) const {
    for (int c = first; c < num_cells(); c += stride) K.add_cell(c, cells[c].data());
  }
};

/// A matrix with the pattern of the system, assembled from cells of it (RandomSystem::assemble).
template <int block_size>
BlockMatrix<block_size> assembled(const RandomSystem<block_size>& system, int first = 0,
                                  int stride = 1) {
  BlockMatrix<block_size> K;
  K.set_pattern(system.num_nodes, system.offsets, system.cell_nodes);
  system.assemble(K, first, stride);
  return K;
}

/// A chain of cells with nodes_per_cell nodes, one of them shared with the cell before, the others
/// drawn from all nodes. The cell matrices are A A^T + 1 (symmetric), plus `skew` times an
/// antisymmetric random matrix: positive definite in any case.
template <int block_size>
RandomSystem<block_size> random_system(std::int32_t num_nodes, int num_cells, int nodes_per_cell,
                                       double skew, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> entry(-1, 1);
  std::vector<std::int32_t> all(num_nodes);
  for (std::int32_t i = 0; i < num_nodes; ++i) all[i] = i;
  RandomSystem<block_size> system;
  system.num_nodes = num_nodes;
  system.dense = Eigen::MatrixXd::Zero(num_nodes * block_size, num_nodes * block_size);
  for (int c = 0; c < num_cells; ++c) {
    std::shuffle(all.begin(), all.end(), random);
    std::vector<std::int32_t> nodes{c % num_nodes};
    for (const std::int32_t i : all)
      if (i != nodes[0] && static_cast<int>(nodes.size()) < nodes_per_cell) nodes.push_back(i);
    const int width = nodes_per_cell * block_size;
    Eigen::MatrixXd A = Eigen::MatrixXd::NullaryExpr(width, width, [&] { return entry(random); });
    Eigen::MatrixXd K = A * A.transpose() / width + Eigen::MatrixXd::Identity(width, width) +
                        skew * (A - A.transpose());
    std::vector<double> values;
    for (int r = 0; r < width; ++r)
      for (int s = 0; s < width; ++s) {
        values.push_back(K(r, s));
        system.dense(nodes[r / block_size] * block_size + r % block_size,
                     nodes[s / block_size] * block_size + s % block_size) += K(r, s);
      }
    system.cells.push_back(std::move(values));
    system.cell_nodes.insert(system.cell_nodes.end(), nodes.begin(), nodes.end());
    system.offsets.push_back(static_cast<std::int32_t>(system.cell_nodes.size()));
  }
  return system;
}

template <int block_size>
Eigen::MatrixXd to_dense(const BlockMatrix<block_size>& K) {
  Eigen::MatrixXd dense =
      Eigen::MatrixXd::Zero(K.num_nodes() * block_size, K.num_nodes() * block_size);
  for (std::int32_t i = 0; i < K.num_nodes(); ++i)
    for (std::int32_t s = K.row_starts()[i]; s < K.row_starts()[i + 1]; ++s)
      dense.template block<block_size, block_size>(i * block_size, K.columns()[s] * block_size) =
          Eigen::Map<const NodeBlock<block_size>>(K.values().data() + s * block_size * block_size);
  return dense;
}

}  // namespace gabion::test
