// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstring>

#include "common/mechanics/petsc/block_matrix.hpp"
#include "common/mechanics/petsc/node_block.hpp"
#include "common/mechanics/simd/lanes.hpp"
#include "common/mechanics/tensor.hpp"

namespace gabion::mpm {

/// right[J stride + k dim dim ...] = sum_L A_(aJ)(bL) grad_kL: the node blocks of the values k of
/// one point, column by column. @param A  see PointTerms
template <int dim>
[[gnu::always_inline]] inline void find_right_sides(int n, const double* A, const Vector<dim>* grad,
                                                    double* right, std::ptrdiff_t stride) {
  using Block = BlockVector<dim>;
  constexpr int size = dim * dim;
  Block A_JL[dim][dim];
  for (int JL = 0; JL < dim * dim; ++JL) A_JL[JL / dim][JL % dim].load(A + JL * size);
  for (int k = 0; k < n; ++k) {
    const Vector<dim> g = grad[k];
    for (int J = 0; J < dim; ++J) {
      Block sum = A_JL[J][0] * g[0];
      for (int L = 1; L < dim; ++L) sum += A_JL[J][L] * g[L];
      sum.store(right + J * stride + k * size);
    }
  }
}

/// left_ia g_kb + g_ia right_kb by the values of three fields at the nodes of a cell, n x dim each.
struct NodalProducts {
  const double *left, *g, *right;
};

/// Each number of g and right as often as a block has rows.
template <int dim>
inline void spread_columns(int n, const NodalProducts& products, double* g, double* right) {
  for (int k = 0; k < n * dim; ++k) {
    for (int a = 0; a < dim; ++a) {
      g[k * dim + a] = products.g[k];
      right[k * dim + a] = products.right[k];
    }
  }
}

/// x of one node in each row of a node block, over `period` vectors of a row of blocks.
template <int dim>
struct RowPattern {
  static constexpr int period = dim == 2 ? 1 : 3;
  Lanes x[period];

  explicit RowPattern(const double* of_node) {
    for (int v = 0; v < period; ++v) {
      for (int l = 0; l < num_lanes; ++l) x[v][l] = of_node[(v * num_lanes + l) % dim];
    }
  }
  const Lanes& operator[](int v) const { return x[v % period]; }
};

/// Blocks of some neighbouring columns in one row of a cell's stiffness, summed up in registers.
/// @tparam num_blocks  as many as fill whole vectors
template <int dim, int num_blocks>
class BlockRow {
 public:
  static constexpr int size = dim * dim;
  static constexpr int num_vectors = num_blocks * size / num_lanes;
  static_assert(num_vectors * num_lanes == num_blocks * size);

  void set_zero() {
    for (Lanes& x : sum_) x = Lanes{};
  }
  /// left_a g_kb + g_a right_kb. @param left, g  of the row's node; the others see RowPattern
  void set_products(const double* left, const double* g_columns, const double* g,
                    const double* right_columns) {
    const RowPattern<dim> left_rows(left), g_rows(g);
    for (int v = 0; v < num_vectors; ++v) {
      sum_[v] = left_rows[v] * load_lanes(g_columns + v * num_lanes) +
                g_rows[v] * load_lanes(right_columns + v * num_lanes);
    }
  }
  /// @param right  of the first of these columns
  void add(const Vector<dim>& grad, const double* right, std::ptrdiff_t stride) {
    for (int J = 0; J < dim; ++J) {
      const Lanes g = lanes(grad[J]);
      for (int v = 0; v < num_vectors; ++v) {
        sum_[v] += g * load_lanes(right + J * stride + v * num_lanes);
      }
    }
  }
  /// Add them to K. @param place  of the first one, see CellBlocks::at
  void add_to(const CellBlocks<dim>& blocks, int place) const {
    if constexpr (size == num_lanes) {
      for (int k = 0; k < num_blocks; ++k) {
        double* target = blocks.at(place + k);
        store_lanes(load_lanes(target) + sum_[k], target);
      }
    } else {
      double values[num_vectors * num_lanes];
      for (int v = 0; v < num_vectors; ++v) store_lanes(sum_[v], values + v * num_lanes);
      for (int k = 0; k < num_blocks; ++k) {
        double* target = blocks.at(place + k);
        BlockVector<dim> block, added;
        block.load(target);
        added.load(values + k * size);
        block += added;
        block.store(target);
      }
    }
  }

 private:
  Lanes sum_[num_vectors];
};

/// target[c] += sum_J g_J right[J stride + c] for `length` blocks side by side.
/// @param g  grad_J in each lane
template <int dim, int length>
inline void add_strip(const Lanes (&g)[dim], const double* right, std::ptrdiff_t stride,
                      double* target) {
  using Pair = double __attribute__((vector_size(16)));
  constexpr int count = length * dim * dim, whole = count - count % num_lanes;
  for (int c = 0; c < whole; c += num_lanes) {
    Lanes sum = load_lanes(target + c);
    for (int J = 0; J < dim; ++J) sum += g[J] * load_lanes(right + J * stride + c);
    store_lanes(sum, target + c);
  }
  if constexpr (count % num_lanes >= 2) {
    Pair sum;
    std::memcpy(&sum, target + whole, sizeof sum);
    for (int J = 0; J < dim; ++J) {
      Pair term;
      std::memcpy(&term, right + J * stride + whole, sizeof term);
      sum += term * g[J][0];
    }
    std::memcpy(target + whole, &sum, sizeof sum);
  }
  if constexpr (count % 2 == 1) {
    double sum = target[count - 1];
    for (int J = 0; J < dim; ++J) sum += g[J][0] * right[J * stride + count - 1];
    target[count - 1] = sum;
  }
}

/// Neighbouring blocks left_a g_kb + g_a right_kb in the row of one node.
template <int dim>
class ProductRow {
 public:
  /// @param left, g  of the row's node, dim each
  ProductRow(const double* left, const double* g)
      : left_(left), g_(g), left_rows_(left), g_rows_(g) {}

  /// @param g_columns, right_columns  of the first column, each number dim times
  void add(int num_blocks, const double* g_columns, const double* right_columns,
           double* target) const {
    constexpr int period = RowPattern<dim>::period;
    const int count = num_blocks * dim * dim;
    int c = 0;
    for (; c + period * num_lanes <= count; c += period * num_lanes) {
      for (int v = 0; v < period; ++v) {
        const int at = c + v * num_lanes;
        const Lanes sum = load_lanes(target + at) + left_rows_[v] * load_lanes(g_columns + at) +
                          g_rows_[v] * load_lanes(right_columns + at);
        store_lanes(sum, target + at);
      }
    }
    for (int a = 0; c < count; ++c, a = a + 1 < dim ? a + 1 : 0) {
      target[c] += left_[a] * g_columns[c] + g_[a] * right_columns[c];
    }
  }

 private:
  const double *left_, *g_;
  RowPattern<dim> left_rows_, g_rows_;
};

}  // namespace gabion::mpm
