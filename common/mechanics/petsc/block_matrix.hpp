// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/mechanics/tensor.hpp"

namespace gabion {

/// Sparse matrix of dim x dim blocks between nodes (block compressed rows; blocks column-major, as
/// PETSc's BAIJ wants them). On several ranks each rank adds the cells it owns; the sum over the
/// ranks is the matrix.
template <int dim>
class BlockMatrix {
 public:
  /// New pattern: nodes that share a cell are coupled; every diagonal block exists. Cell c has the
  /// nodes cell_nodes[offsets[c] .. offsets[c + 1]), numbered 0 .. num_nodes - 1.
  void set_pattern(std::int32_t num_nodes, std::span<const std::int32_t> offsets,
                   std::span<const std::int32_t> cell_nodes);

  std::int32_t num_nodes() const { return num_nodes_; }
  void set_zero();

  /// Add the dense matrix of cell c (as numbered in set_pattern), (n dim) x (n dim), row-major.
  void add_cell(std::int32_t c, const double* K);
  /// Add one block. @pre i and j share a cell of the pattern
  void add_block(std::int32_t i, std::int32_t j, const Matrix<dim>& block);
  void add_diagonal(std::int32_t i, double value);  ///< value times the unit block

  /// Constrain the increment of node i to the range of the projector Q_i (symmetric, Q Q = Q):
  /// K_ij <- Q_i K_ij Q_j, then add scale_i (1 - Q_i) to the diagonal block where `owned` is true.
  /// `constrained` lists the nodes whose projector is not the unit matrix.
  void constrain(std::span<const std::int32_t> constrained,
                 std::span<const Matrix<dim>> projectors, bool owned);

  std::span<const std::int32_t> row_starts() const { return row_starts_; }
  std::span<const std::int32_t> columns() const { return columns_; }
  std::span<const double> values() const { return values_; }
  std::span<double> values() { return values_; }

  /// y = K x with this rank's blocks only.
  void multiply(std::span<const double> x, std::span<double> y) const;

 private:
  std::int32_t num_nodes_ = 0;
  std::vector<std::int32_t> row_starts_;  // blocks
  std::vector<std::int32_t> columns_;     // sorted in each row
  std::vector<double> values_;
  std::vector<std::int32_t> offsets_, cell_nodes_;
  std::vector<std::int32_t> slots_;        // block index of each node pair of each cell
  std::vector<std::int64_t> slot_starts_;  // of each cell in slots_
};

}  // namespace gabion
