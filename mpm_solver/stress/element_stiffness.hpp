// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "common/mechanics/petsc/block_matrix.hpp"
#include "mpm_solver/stress/block_rows.hpp"

namespace gabion::mpm {

/// CellStiffness where all nodes of a cell act on all its points, in their order
/// (PointWeights::whole_cells): a row of blocks is summed over the points before it goes to K.
/// @tparam n  number of nodes of the cell
template <int dim, int n>
class ElementStiffness {
 public:
  static constexpr int block_size = dim * dim;

  void start(int, const CellBlocks<dim>& blocks) {
    blocks_ = blocks;
    has_products_ = false;
    num_points_ = 0;
  }
  /// @param products  last until `finish`
  void add(const NodalProducts& products) {
    spread_columns<dim>(n, products, g_columns_, right_columns_);
    products_ = products;
    has_products_ = true;
  }
  /// @param grad  of the n nodes, lasts until `finish`
  /// @param A     see PointTerms
  void add_point(int, const std::uint8_t*, const Vector<dim>* grad, const double* A) {
    if (num_points_ == most_points) add_rows();
    grads_[num_points_] = grad;
    find_right_sides<dim>(n, A, grad, right_[num_points_++], stride);
  }
  void finish() {
    if (num_points_ > 0 || has_products_) add_rows();
  }

 private:
  static constexpr int most_points = 8;  // at once
  static constexpr std::ptrdiff_t stride = n * block_size;
  static constexpr int width = n <= 4 ? n : 4;  // number of blocks that fit into the registers

  void add_rows() {
    for (int i = 0; i < n; ++i) {
      for (int first = 0; first < n; first += width) {
        BlockRow<dim, width> row;
        if (has_products_) {
          row.set_products(products_.left + i * dim, g_columns_ + first * block_size,
                           products_.g + i * dim, right_columns_ + first * block_size);
        } else {
          row.set_zero();
        }
        for (int p = 0; p < num_points_; ++p) {
          row.add(grads_[p][i], right_[p] + first * block_size, stride);
        }
        row.add_to(blocks_, i * n + first);
      }
    }
    num_points_ = 0;
    has_products_ = false;
  }

  CellBlocks<dim> blocks_;
  NodalProducts products_;
  bool has_products_ = false;
  double g_columns_[n * block_size], right_columns_[n * block_size];
  int num_points_ = 0;
  const Vector<dim>* grads_[most_points];
  double right_[most_points][dim * n * block_size];
};

}  // namespace gabion::mpm
