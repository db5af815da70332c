// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/petsc/block_matrix.hpp"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cmath>

#include "common/base/require.hpp"

namespace gabion {

namespace {

std::int64_t next_pattern_id() {
  static std::atomic<std::int64_t> last{0};
  return ++last;
}

/// Scatter a dense (n block_size) x (n block_size) row-major matrix to column-major blocks.
template <int block_size>
inline void scatter(int n, const std::int32_t* slots, const double* K, double* values) {
  const int width = n * block_size;
  for (int a = 0; a < n; ++a) {
    const double* rows = K + a * block_size * width;
    for (int b = 0; b < n; ++b) {
      double* target =
          values + static_cast<std::size_t>(slots[a * n + b]) * block_size * block_size;
      const double* source = rows + b * block_size;
      for (int c = 0; c < block_size; ++c)
        for (int r = 0; r < block_size; ++r) target[c * block_size + r] += source[r * width + c];
    }
  }
}

}  // namespace

template <int block_size>
void BlockMatrix<block_size>::set_pattern(std::int32_t num_nodes,
                                          std::span<const std::int32_t> offsets,
                                          std::span<const std::int32_t> cell_nodes) {
  assert(!offsets.empty() && static_cast<std::size_t>(offsets.back()) == cell_nodes.size());
  const bool same = pattern_id_ > 0 && num_nodes == num_nodes_ &&
                    std::ranges::equal(offsets, offsets_) &&
                    std::ranges::equal(cell_nodes, cell_nodes_);
  if (same) return set_zero();
  num_nodes_ = num_nodes;
  pattern_id_ = next_pattern_id();
  offsets_.assign(offsets.begin(), offsets.end());
  cell_nodes_.assign(cell_nodes.begin(), cell_nodes.end());
  list_cells_of_nodes();
  list_neighbours();
  sort_columns();
  map_cells();
  values_.assign(columns_.size() * block_size * block_size, 0.0);
}

template <int block_size>
void BlockMatrix<block_size>::list_cells_of_nodes() {
  corner_starts_.assign(static_cast<std::size_t>(num_nodes_) + 1, 0);
  for (const std::int32_t i : cell_nodes_) ++corner_starts_[i + 1];
  for (std::int32_t i = 0; i < num_nodes_; ++i) corner_starts_[i + 1] += corner_starts_[i];
  marks_.assign(corner_starts_.begin(), corner_starts_.end() - 1);
  corners_.resize(cell_nodes_.size());
  const auto num_cells = static_cast<std::int32_t>(offsets_.size()) - 1;
  for (std::int32_t c = 0; c < num_cells; ++c)
    for (std::int32_t k = offsets_[c]; k < offsets_[c + 1]; ++k)
      corners_[marks_[cell_nodes_[k]]++] = {c, k - offsets_[c]};
}

template <int block_size>
void BlockMatrix<block_size>::list_neighbours() {
  marks_.assign(static_cast<std::size_t>(num_nodes_), -1);
  row_starts_.resize(static_cast<std::size_t>(num_nodes_) + 1);
  neighbours_.clear();
  row_starts_[0] = 0;
  for (std::int32_t i = 0; i < num_nodes_; ++i) {
    marks_[i] = i;
    neighbours_.push_back(i);
    for (std::int32_t k = corner_starts_[i]; k < corner_starts_[i + 1]; ++k) {
      const std::int32_t c = corners_[k].cell;
      for (std::int32_t p = offsets_[c]; p < offsets_[c + 1]; ++p) {
        const std::int32_t j = cell_nodes_[p];
        if (marks_[j] == i) continue;
        marks_[j] = i;
        neighbours_.push_back(j);
      }
    }
    row_starts_[i + 1] = static_cast<std::int32_t>(neighbours_.size());
  }
}

// The pattern is symmetric: visiting the rows j in order and appending j to each of its neighbours'
// rows leaves every row sorted.
template <int block_size>
void BlockMatrix<block_size>::sort_columns() {
  marks_.assign(row_starts_.begin(), row_starts_.end() - 1);
  columns_.resize(neighbours_.size());
  for (std::int32_t j = 0; j < num_nodes_; ++j)
    for (std::int32_t k = row_starts_[j]; k < row_starts_[j + 1]; ++k)
      columns_[marks_[neighbours_[k]]++] = j;
}

template <int block_size>
void BlockMatrix<block_size>::map_cells() {
  const std::size_t num_cells = offsets_.size() - 1;
  slot_starts_.resize(num_cells + 1);
  slot_starts_[0] = 0;
  for (std::size_t c = 0; c < num_cells; ++c) {
    const std::int64_t n = offsets_[c + 1] - offsets_[c];
    slot_starts_[c + 1] = slot_starts_[c] + n * n;
  }
  slots_.resize(static_cast<std::size_t>(slot_starts_[num_cells]));
  for (std::int32_t i = 0; i < num_nodes_; ++i) {
    for (std::int32_t s = row_starts_[i]; s < row_starts_[i + 1]; ++s) marks_[columns_[s]] = s;
    for (std::int32_t k = corner_starts_[i]; k < corner_starts_[i + 1]; ++k) {
      const auto [c, a] = corners_[k];
      const std::int32_t n = offsets_[c + 1] - offsets_[c];
      std::int32_t* row = slots_.data() + slot_starts_[c] + static_cast<std::int64_t>(a) * n;
      for (std::int32_t b = 0; b < n; ++b) row[b] = marks_[cell_nodes_[offsets_[c] + b]];
    }
  }
}

template <int block_size>
void BlockMatrix<block_size>::set_zero() {
  std::fill(values_.begin(), values_.end(), 0.0);
}

template <int block_size>
void BlockMatrix<block_size>::add_cell(std::int32_t c, const double* K) {
  const int n = offsets_[c + 1] - offsets_[c];
  const std::int32_t* slots = slots_.data() + slot_starts_[c];
  // Constant sizes let the compiler unroll triangles, quadrilaterals and tetrahedra, bricks.
  switch (n) {
    case 3:
      return scatter<block_size>(3, slots, K, values_.data());
    case 4:
      return scatter<block_size>(4, slots, K, values_.data());
    case 8:
      return scatter<block_size>(8, slots, K, values_.data());
    default:
      return scatter<block_size>(n, slots, K, values_.data());
  }
}

template <int block_size>
void BlockMatrix<block_size>::add_cell_blocks(std::int32_t c, const double* blocks) {
  const std::int64_t n = offsets_[c + 1] - offsets_[c];
  const std::int32_t* slots = slots_.data() + slot_starts_[c];
  for (std::int64_t k = 0; k < n * n; ++k) {
    double* target = block(slots[k]);
    BlockVector<block_size> sum, added;
    sum.load(target);
    added.load(blocks + k * BlockVector<block_size>::num_entries);
    sum += added;
    sum.store(target);
  }
}

template <int block_size>
std::int32_t BlockMatrix<block_size>::slot(std::int32_t i, std::int32_t j) const {
  const auto begin = columns_.begin() + row_starts_[i];
  const auto end = columns_.begin() + row_starts_[i + 1];
  const auto found = std::lower_bound(begin, end, j);
  assert(found != end && *found == j);
  return static_cast<std::int32_t>(found - columns_.begin());
}

template <int block_size>
void BlockMatrix<block_size>::add_block(std::int32_t i, std::int32_t j,
                                        const NodeBlock<block_size>& added) {
  Eigen::Map<NodeBlock<block_size>>(block(slot(i, j))) += added;
}

template <int block_size>
void BlockMatrix<block_size>::add_diagonal(std::int32_t i, double value) {
  double* target = block(slot(i, i));
  for (int r = 0; r < block_size; ++r) target[r * block_size + r] += value;
}

template <int block_size>
double BlockMatrix<block_size>::mean_diagonal() const {
  double sum = 0;
  for (std::int32_t i = 0; i < num_nodes_; ++i) {
    const double* diagonal =
        values_.data() + static_cast<std::size_t>(slot(i, i)) * block_size * block_size;
    for (int r = 0; r < block_size; ++r) sum += std::abs(diagonal[r * block_size + r]);
  }
  const double mean = num_nodes_ > 0 ? sum / (num_nodes_ * block_size) : 0;
  return mean > 0 ? mean : 1;
}

template <int block_size>
void BlockMatrix<block_size>::constrain(std::span<const std::int32_t> constrained,
                                        std::span<const NodeBlock<block_size>> projectors,
                                        const std::function<bool(std::int32_t)>& owned) {
  require(constrained.size() == projectors.size(),
          "BlockMatrix::constrain: " + std::to_string(constrained.size()) + " nodes, but " +
              std::to_string(projectors.size()) + " projectors");
  if (constrained.empty()) return;
  const auto own_scale_of = [this](std::int32_t i) {
    return Eigen::Map<NodeBlock<block_size>>(block(slot(i, i))).diagonal().cwiseAbs().mean();
  };
  const bool any_empty =
      std::ranges::any_of(constrained, [&](auto i) { return !(own_scale_of(i) > 0); });
  const double fallback_scale = any_empty ? mean_diagonal() : 0;
  for (std::size_t k = 0; k < constrained.size(); ++k) {
    const std::int32_t i = constrained[k];
    const NodeBlock<block_size>& Q = projectors[k];
    Eigen::Map<NodeBlock<block_size>> diagonal(block(slot(i, i)));
    const double own_scale = own_scale_of(i);
    for (std::int32_t s = row_starts_[i]; s < row_starts_[i + 1]; ++s) {
      Eigen::Map<NodeBlock<block_size>> row_block(block(s));
      row_block = (Q * row_block).eval();
      Eigen::Map<NodeBlock<block_size>> column_block(block(slot(columns_[s], i)));
      column_block = (column_block * Q).eval();
    }
    if (owned(i))
      diagonal +=
          (own_scale > 0 ? own_scale : fallback_scale) * (NodeBlock<block_size>::Identity() - Q);
  }
}

template <int block_size>
void BlockMatrix<block_size>::multiply(std::span<const double> x, std::span<double> y) const {
  for (std::int32_t i = 0; i < num_nodes_; ++i) {
    double sum[block_size] = {};
    for (std::int32_t s = row_starts_[i]; s < row_starts_[i + 1]; ++s) {
      const double* a = values_.data() + static_cast<std::size_t>(s) * block_size * block_size;
      const double* x_j = x.data() + static_cast<std::size_t>(columns_[s]) * block_size;
      for (int c = 0; c < block_size; ++c)
        for (int r = 0; r < block_size; ++r) sum[r] += a[c * block_size + r] * x_j[c];
    }
    for (int r = 0; r < block_size; ++r) y[static_cast<std::size_t>(i) * block_size + r] = sum[r];
  }
}

template class BlockMatrix<1>;
template class BlockMatrix<2>;
template class BlockMatrix<3>;
template class BlockMatrix<6>;

}  // namespace gabion
