// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>

#include "common/mechanics/petsc/block_matrix.hpp"
#include "common/mechanics/simd/lanes.hpp"
#include "mpm_solver/grid/basis.hpp"
#include "mpm_solver/stress/block_rows.hpp"

namespace gabion::mpm {

/// Adds the stiffness of the points of one cell to K,
///
///     K_(ia)(kb) += sum_p grad_iJ A_(aJ)(bL) grad_kL   [+ left_ia g_kb + g_ia right_kb]
///
/// each point's blocks where they lie.
template <int dim>
class CellStiffness {
 public:
  static constexpr int block_size = dim * dim;
  static constexpr int max_nodes = max_group_nodes<dim>;

  /// @param n  number of nodes of the cell
  void start(int n, const CellBlocks<dim>& blocks) {
    n_ = n;
    blocks_ = blocks;
    const auto runs = blocks.runs();
    for (std::size_t r = 0; r < runs.size(); ++r) {
      const int end = r + 1 < runs.size() ? runs[r + 1] : n;
      for (int b = runs[r]; b < end; ++b) {
        run_of_[b] = static_cast<std::uint8_t>(r);
        offset_of_[b] = static_cast<std::uint8_t>(b - runs[r]);
      }
    }
  }

  void add(const NodalProducts& products) {
    spread_columns<dim>(n_, products, g_columns_, right_columns_);
    const auto runs = blocks_.runs();
    for (int i = 0; i < n_; ++i) {
      const ProductRow<dim> row(products.left + i * dim, products.g + i * dim);
      for (std::size_t r = 0; r < runs.size(); ++r) {
        const int end = r + 1 < runs.size() ? runs[r + 1] : n_;
        const std::ptrdiff_t first = runs[r] * block_size;
        row.add(end - runs[r], g_columns_ + first, right_columns_ + first,
                blocks_.at(i, static_cast<int>(r)));
      }
    }
  }

  /// @param n, local, grad  values of the point: their number, each one's node and gradient
  /// @param A               see PointTerms
  void add_point(int n, const std::uint8_t* local, const Vector<dim>* grad, const double* A) {
    find_right_sides<dim>(n, A, grad, right_, stride);
    switch (find_strips(n, local)) {
      case 3:
        return add_rows<3>(n, local, grad);
      case 2:
        return add_rows<2>(n, local, grad);
      case 1:
        return add_rows<1>(n, local, grad);
      default:
        return add_any_rows(n, local, grad);
    }
  }
  /// End the cell: all its points were added.
  void finish() {}

 private:
  static constexpr std::ptrdiff_t stride = max_nodes * block_size;
  /// Consecutive values of a point whose blocks lie side by side in each row of K.
  struct Strip {
    std::uint8_t first, length, run, offset;
  };

  // @returns the length of the strips, 0 where they differ
  int find_strips(int n, const std::uint8_t* local) {
    num_strips_ = 0;
    for (int k = 0; k < n; ++k) {
      const int b = local[k];
      const bool goes_on = k > 0 && b == local[k - 1] + 1 && run_of_[b] == run_of_[b - 1];
      if (goes_on) {
        ++strips_[num_strips_ - 1].length;
      } else {
        strips_[num_strips_++] = {static_cast<std::uint8_t>(k), 1, run_of_[b], offset_of_[b]};
      }
    }
    const int length = strips_[0].length;
    for (int s = 1; s < num_strips_; ++s) {
      if (strips_[s].length != length) return 0;
    }
    return length;
  }

  // Strips of one length.
  template <int length>
  void add_rows(int n, const std::uint8_t* local, const Vector<dim>* grad) {
    const CellBlocks<dim> blocks = blocks_;
    const int num_runs = static_cast<int>(blocks.runs().size()), num_strips = num_strips_;
    std::ptrdiff_t runs[max_nodes], offsets[max_nodes];
    for (int s = 0; s < num_strips; ++s) {
      runs[s] = strips_[s].run;
      offsets[s] = strips_[s].offset * block_size;
    }
    for (int i = 0; i < n; ++i) {
      Lanes g[dim];
      for (int J = 0; J < dim; ++J) g[J] = lanes(grad[i][J]);
      const int row = local[i] * num_runs;
      const double* right = right_;
      for (int s = 0; s < num_strips; ++s, right += length * block_size) {
        double* target = blocks.at(row + static_cast<int>(runs[s])) + offsets[s];
        add_strip<dim, length>(g, right, stride, target);
      }
    }
  }
  void add_any_rows(int n, const std::uint8_t* local, const Vector<dim>* grad) {
    for (int i = 0; i < n; ++i) {
      Lanes g[dim];
      for (int J = 0; J < dim; ++J) g[J] = lanes(grad[i][J]);
      for (int s = 0; s < num_strips_; ++s) {
        const Strip strip = strips_[s];
        double* target = blocks_.at(local[i], strip.run) + strip.offset * block_size;
        const double* right = right_ + strip.first * block_size;
        for (int k = 0; k < strip.length * block_size; k += block_size) {
          add_strip<dim, 1>(g, right + k, stride, target + k);
        }
      }
    }
  }

  int n_ = 0;
  CellBlocks<dim> blocks_;
  std::uint8_t run_of_[max_nodes], offset_of_[max_nodes];
  double g_columns_[max_nodes * block_size], right_columns_[max_nodes * block_size];
  int num_strips_ = 0;
  Strip strips_[max_nodes];
  double right_[dim * max_nodes * block_size];
};

}  // namespace gabion::mpm
