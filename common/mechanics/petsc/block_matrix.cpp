// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/petsc/block_matrix.hpp"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cmath>

#include "common/base/require.hpp"
#include "common/base/reserve.hpp"
#include "common/mechanics/petsc/block_multiply.hpp"

namespace gabion {

namespace {

// Longer rows are rare.
constexpr std::size_t likely_row = 343;

std::int64_t next_pattern_id() {
  static std::atomic<std::int64_t> last{0};
  return ++last;
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
  place_values();
  set_zero();
}

template <int block_size>
void BlockMatrix<block_size>::place_values() {
  const std::size_t size = columns_.size() * block_size * block_size;
  values_ = storage_ ? storage_(*this) : std::span<double>();
  if (values_.empty()) {
    if (size > own_values_.capacity()) own_values_ = {};  // not the old and the new ones at once
    reserve_tightly(own_values_, size);
    own_values_.resize(size);
    values_ = own_values_;
  }
  require(values_.size() == size, "BlockMatrix: found room for {} values, needed: {}",
          values_.size(), size);
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
    reserve_tightly(neighbours_, neighbours_.size() + likely_row);
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
  reserve_tightly(columns_, neighbours_.size());
  columns_.resize(neighbours_.size());
  diagonal_.resize(num_nodes_);
  for (std::int32_t j = 0; j < num_nodes_; ++j) {
    for (std::int32_t k = row_starts_[j]; k < row_starts_[j + 1]; ++k) {
      const std::int32_t slot = marks_[neighbours_[k]]++;
      columns_[slot] = j;
      if (neighbours_[k] == j) diagonal_[j] = slot;
    }
  }
}

// Where the numbers of a cell's nodes go up by one, so do the slots of their blocks in each row.
template <int block_size>
void BlockMatrix<block_size>::find_runs() {
  const std::size_t num_cells = offsets_.size() - 1;
  runs_.clear();
  run_starts_.assign(1, 0);
  slot_starts_.assign(1, 0);
  for (std::size_t c = 0; c < num_cells; ++c) {
    const bool single = offsets_[c + 1] - offsets_[c] <= CellBlocks<block_size>::most_single;
    for (std::int32_t k = offsets_[c]; k < offsets_[c + 1]; ++k) {
      const bool goes_on = !single && k > offsets_[c] && cell_nodes_[k] == cell_nodes_[k - 1] + 1;
      if (!goes_on) runs_.push_back(k - offsets_[c]);
    }
    const auto num_runs = static_cast<std::int64_t>(runs_.size()) - run_starts_.back();
    run_starts_.push_back(static_cast<std::int64_t>(runs_.size()));
    slot_starts_.push_back(slot_starts_.back() + num_runs * (offsets_[c + 1] - offsets_[c]));
  }
}

template <int block_size>
void BlockMatrix<block_size>::map_cells() {
  find_runs();
  reserve_tightly(slots_, static_cast<std::size_t>(slot_starts_.back()));
  slots_.resize(static_cast<std::size_t>(slot_starts_.back()));
  for (std::int32_t i = 0; i < num_nodes_; ++i) {
    for (std::int32_t s = row_starts_[i]; s < row_starts_[i + 1]; ++s) marks_[columns_[s]] = s;
    for (std::int32_t k = corner_starts_[i]; k < corner_starts_[i + 1]; ++k) {
      const auto [c, a] = corners_[k];
      const auto runs = runs_of(c);
      std::int32_t* row =
          slots_.data() + slot_starts_[c] + static_cast<std::int64_t>(a * runs.size());
      for (const std::int32_t b : runs) *row++ = marks_[cell_nodes_[offsets_[c] + b]];
    }
  }
}

template <int block_size>
void BlockMatrix<block_size>::set_zero() {
  std::fill(values_.begin(), values_.end(), 0.0);
}

// Visit the blocks of a cell that lie side by side: add(a, first, last, values) with those of its
// nodes a and first .. last - 1.
template <int block_size>
template <class Add>
void BlockMatrix<block_size>::for_each_run(std::int32_t c, const Add& add) {
  const int n = offsets_[c + 1] - offsets_[c];
  const auto runs = runs_of(c);
  const std::int32_t* slot = slots_.data() + slot_starts_[c];
  for (int a = 0; a < n; ++a) {
    for (std::size_t r = 0; r < runs.size(); ++r) {
      add(a, runs[r], r + 1 < runs.size() ? runs[r + 1] : n, block(*slot++));
    }
  }
}

template <int block_size>
void BlockMatrix<block_size>::add_cell(std::int32_t c, const double* K) {
  const int width = (offsets_[c + 1] - offsets_[c]) * block_size;
  for_each_run(c, [&](int a, int first, int last, double* target) {
    const double* rows = K + a * block_size * width;
    for (int column = first * block_size; column < last * block_size; ++column) {
      for (int r = 0; r < block_size; ++r) *target++ += rows[r * width + column];
    }
  });
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
  double* target = block(diagonal_[i]);
  for (int r = 0; r < block_size; ++r) target[r * block_size + r] += value;
}

template <int block_size>
double BlockMatrix<block_size>::mean_diagonal() const {
  double sum = 0;
  for (std::int32_t i = 0; i < num_nodes_; ++i) {
    const double* diagonal =
        values_.data() + static_cast<std::size_t>(diagonal_[i]) * block_size * block_size;
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
    return Eigen::Map<NodeBlock<block_size>>(block(diagonal_[i])).diagonal().cwiseAbs().mean();
  };
  const bool any_empty =
      std::ranges::any_of(constrained, [&](auto i) { return !(own_scale_of(i) > 0); });
  const double fallback_scale = any_empty ? mean_diagonal() : 0;
  for (std::size_t k = 0; k < constrained.size(); ++k) {
    const std::int32_t i = constrained[k];
    const NodeBlock<block_size>& Q = projectors[k];
    Eigen::Map<NodeBlock<block_size>> diagonal(block(diagonal_[i]));
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
std::size_t BlockMatrix<block_size>::pattern_bytes() const {
  std::size_t sum = 0;
  const auto add = [&sum]<class Value>(const std::vector<Value>& list) {
    sum += list.capacity() * sizeof(Value);
  };
  for (const auto* list : {&row_starts_, &columns_, &offsets_, &cell_nodes_, &runs_, &slots_,
                           &corner_starts_, &neighbours_, &marks_, &diagonal_})
    add(*list);
  add(run_starts_);
  add(slot_starts_);
  add(corners_);
  return sum;
}

template <int block_size>
void BlockMatrix<block_size>::multiply(std::span<const double> x, std::span<double> y) const {
  multiply_blocks<block_size>({row_starts_.data(), columns_.data(), values_.data()}, num_nodes_,
                              x.data(), y.data());
}

template class BlockMatrix<2>;
template class BlockMatrix<3>;
template class BlockMatrix<4>;

}  // namespace gabion
