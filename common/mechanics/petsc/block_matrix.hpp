// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "common/mechanics/petsc/node_block.hpp"

namespace gabion {

/// Places of the blocks of one cell in a BlockMatrix.
template <int block_size>
class CellBlocks {
 public:
  CellBlocks() = default;
  CellBlocks(std::span<const std::int32_t> runs, const std::int32_t* slots, double* values)
      : runs_(runs), slots_(slots), values_(values) {}

  /// First nodes of the runs: those of a run are neighbours in each row of the matrix. Where a cell
  /// has few nodes (`most_single`) each of them is a run.
  std::span<const std::int32_t> runs() const { return runs_; }
  /// Block of node a and the first node of run r; those of the run's other nodes follow.
  double* at(int a, int r) const { return at(a * static_cast<int>(runs_.size()) + r); }
  /// The block at place a * (number of runs) + r.
  double* at(int place) const {
    return values_ + static_cast<std::ptrdiff_t>(slots_[place]) * block_size * block_size;
  }

  static constexpr int most_single = block_size == 3 ? 8 : 4;

 private:
  std::span<const std::int32_t> runs_;
  const std::int32_t* slots_ = nullptr;
  double* values_ = nullptr;
};

/// Sparse matrix of blocks between nodes (block compressed rows; blocks column-major, as PETSc's
/// BAIJ wants them). On several ranks each rank adds the cells it owns; the sum over the ranks is
/// the matrix.
/// @tparam block_size  number of unknowns of a node, whatever they are: 2, 3 or 4
template <int block_size>
class BlockMatrix {
 public:
  /// Room for the values of a pattern, or nothing.
  using Storage = std::function<std::span<double>(const BlockMatrix& pattern)>;

  BlockMatrix() = default;
  /// @param storage  asked at each new pattern for room that lasts to the next one, such as that of
  ///                 the PETSc matrix which the values are for; where it has none they are kept
  ///                 here
  explicit BlockMatrix(Storage storage) : storage_(std::move(storage)) {}
  BlockMatrix(const BlockMatrix&) = delete;  // values_ may refer to own_values_
  BlockMatrix& operator=(const BlockMatrix&) = delete;
  BlockMatrix(BlockMatrix&&) noexcept = default;
  BlockMatrix& operator=(BlockMatrix&&) noexcept = default;
  ~BlockMatrix() = default;

  /// New pattern with all blocks zero: nodes that share a cell are coupled; every diagonal block
  /// exists. Cell c has the nodes cell_nodes[offsets[c] .. offsets[c + 1]), numbered
  /// 0 .. num_nodes - 1. Work and memory grow with the number of node pairs; buffers are reused,
  /// and the same cells as before cost no more than a comparison.
  void set_pattern(std::int32_t num_nodes, std::span<const std::int32_t> offsets,
                   std::span<const std::int32_t> cell_nodes);

  std::int32_t num_nodes() const { return num_nodes_; }
  /// Number of the pattern, another one for each pattern in this process; 0 before the first.
  /// Setting the same cells again keeps it.
  std::int64_t pattern_id() const { return pattern_id_; }
  void set_zero();

  /// Add the dense matrix of cell c (as numbered in set_pattern), (n block_size) x (n block_size),
  /// row-major.
  void add_cell(std::int32_t c, const double* K);
  /// Blocks of a cell, for a sum block by block, see above.
  CellBlocks<block_size> cell_blocks(std::int32_t c) {
    return {runs_of(c), slots_.data() + slot_starts_[c], values_.data()};
  }
  /// Add one block. @pre i and j share a cell of the pattern
  void add_block(std::int32_t i, std::int32_t j, const NodeBlock<block_size>& block);
  void add_diagonal(std::int32_t i, double value);  ///< value times the unit block
  double mean_diagonal() const;                     ///< mean over all unknowns

  /// Constrain the increment of each listed node i to the range of its projector Q_i (symmetric,
  /// Q Q = Q): K_ij <- Q_i K_ij Q_j, then, where the node is owned, add scale_i (1 - Q_i) to the
  /// diagonal block. scale_i is the mean diagonal entry of the block before, or of the whole matrix
  /// where the block holds none. Nodes that are not listed have the unit projector.
  /// @param constrained  node numbers, each once
  /// @param projectors   projectors[k] belongs to node constrained[k]
  /// @param owned        of a node: on several ranks true on exactly one of them
  /// @throws Error when the two lists differ in length
  void constrain(std::span<const std::int32_t> constrained,
                 std::span<const NodeBlock<block_size>> projectors,
                 const std::function<bool(std::int32_t)>& owned);

  std::span<const std::int32_t> row_starts() const { return row_starts_; }
  std::span<const std::int32_t> columns() const { return columns_; }
  std::span<const std::int32_t> diagonal() const { return diagonal_; }  ///< slots of (i, i)
  std::span<const double> values() const { return values_; }
  std::span<double> values() { return values_; }
  std::size_t pattern_bytes() const;  ///< memory of all but the values

  /// y = K x with this rank's blocks only; num_nodes x block_size each.
  void multiply(std::span<const double> x, std::span<double> y) const;

 private:
  /// Position of block (i, j) in columns_. @pre it exists
  std::int32_t slot(std::int32_t i, std::int32_t j) const;
  double* block(std::int32_t s) {
    return values_.data() + static_cast<std::size_t>(s) * block_size * block_size;
  }
  void list_cells_of_nodes();
  void list_neighbours();
  void sort_columns();
  void place_values();
  void find_runs();
  void map_cells();
  std::span<const std::int32_t> runs_of(std::int32_t c) const {
    return std::span(runs_).subspan(run_starts_[c], run_starts_[c + 1] - run_starts_[c]);
  }
  template <class Add>
  void for_each_run(std::int32_t c, const Add& add);

  std::int32_t num_nodes_ = 0;
  std::int64_t pattern_id_ = 0;
  std::vector<std::int32_t> row_starts_;  // blocks
  std::vector<std::int32_t> columns_;     // sorted in each row
  std::vector<std::int32_t> diagonal_;    // slot of each node's own block
  Storage storage_;
  std::vector<double> own_values_;  // empty: kept elsewhere
  std::span<double> values_;
  std::vector<std::int32_t> offsets_, cell_nodes_;
  std::vector<std::int32_t> runs_;  // of each cell: where nodes with consecutive numbers begin
  std::vector<std::int64_t> run_starts_;   // of each cell in runs_
  std::vector<std::int32_t> slots_;        // of each cell: of each node and run, its first block
  std::vector<std::int64_t> slot_starts_;  // of each cell in slots_

  struct Corner {
    std::int32_t cell, local;
  };
  std::vector<Corner> corners_;              // cells of each node
  std::vector<std::int32_t> corner_starts_;  // of each node in corners_
  std::vector<std::int32_t> neighbours_;     // columns before sorting
  std::vector<std::int32_t> marks_;          // scratch, one a node
};

}  // namespace gabion
