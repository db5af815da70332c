// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>

#include "common/mechanics/petsc/node_block.hpp"
#include "mpm_solver/grid/basis.hpp"

namespace gabion::mpm {

/// A second-order tensor, row by row.
template <int dim>
using Flat = Vector<dim * dim>;

template <int dim>
Flat<dim> row_by_row(const Matrix<dim>& m) {
  Flat<dim> f;
  for (int aJ = 0; aJ < dim * dim; ++aJ) f[aJ] = m(aJ / dim, aJ % dim);
  return f;
}

/// f_ia += P_aJ grad_iJ
/// @param n, local, grad  values of a point: their number, each one's node and gradient
template <int dim>
void add_gradients(int n, const std::uint8_t* local, const Flat<dim>& P, const Vector<dim>* grad,
                   double* f) {
  for (int i = 0; i < n; ++i) {
    double* f_i = f + local[i] * dim;
    for (int a = 0; a < dim; ++a) {
      double sum = f_i[a];
      for (int J = 0; J < dim; ++J) sum += P[a * dim + J] * grad[i][J];
      f_i[a] = sum;
    }
  }
}

/// Force and stiffness of one cell, added up over its material points.
template <int dim>
struct CellForces {
  static constexpr int max_dofs = max_group_nodes<dim> * dim;
  static constexpr int num_entries = BlockVector<dim>::num_entries;  // of a block
  double f[max_dofs];
  /// Node blocks as BlockMatrix wants them, that of nodes i and k of n at (i n + k) num_entries.
  double K[max_dofs * max_dofs];

  void set_zero(int n, bool with_K) {
    std::fill_n(f, n * dim, 0.0);
    if (with_K) std::fill_n(K, n * n * num_entries, 0.0);
  }

  void add_stress(int n, const std::uint8_t* local, const Matrix<dim>& P, const Vector<dim>* grad) {
    add_gradients<dim>(n, local, row_by_row<dim>(P), grad, f);
  }

  /// Add the n nodes' forces to a nodal field. @param active  numbers of the nodes in the field
  void scatter(int n, const std::int32_t* active, double* field) const {
    for (int i = 0; i < n; ++i) {
      double* at_node = field + static_cast<std::ptrdiff_t>(active[i]) * dim;
      for (int a = 0; a < dim; ++a) at_node[a] += f[i * dim + a];
    }
  }

  /// K_(ia)(kb) = left_ia g_kb + g_ia right_kb
  /// @param n  number of nodes of the cell
  void set_products(int n, const double* left, const double* g, const double* right) {
    for (int i = 0; i < n; ++i) {
      const auto left_i = BlockVector<dim>::rows(left + i * dim);
      const auto g_i = BlockVector<dim>::rows(g + i * dim);
      double* row = K + static_cast<std::ptrdiff_t>(i) * n * num_entries;
      for (int k = 0; k < n; ++k) {
        auto block = left_i * BlockVector<dim>::columns(g + k * dim);
        block += g_i * BlockVector<dim>::columns(right + k * dim);
        block.store(row + k * num_entries);
      }
    }
  }

  /// K_(ia)(kb) += grad_iJ A_(aJ)(bL) grad_kL
  /// @param width  number of nodes of the cell
  void add_tangent(int n, const std::uint8_t* local, int width, const Tangent<dim>& A,
                   const Vector<dim>* grad) {
    BlockVector<dim> A_JL[dim][dim];
    for (int J = 0; J < dim; ++J) {
      for (int L = 0; L < dim; ++L) {
        double entries[num_entries];
        for (int b = 0; b < dim; ++b) {
          for (int a = 0; a < dim; ++a) entries[b * dim + a] = A(a * dim + J, b * dim + L);
        }
        A_JL[J][L].load(entries);
      }
    }
    for (int i = 0; i < n; ++i) {
      BlockVector<dim> left[dim];  // grad_iJ A_(aJ)(bL)
      for (int L = 0; L < dim; ++L) {
        left[L] = A_JL[0][L] * grad[i][0];
        for (int J = 1; J < dim; ++J) left[L] += A_JL[J][L] * grad[i][J];
      }
      double* row = K + static_cast<std::ptrdiff_t>(local[i]) * width * num_entries;
      for (int k = 0; k < n; ++k) {
        double* at = row + local[k] * num_entries;
        BlockVector<dim> block;
        block.load(at);
        for (int L = 0; L < dim; ++L) block += left[L] * grad[k][L];
        block.store(at);
      }
    }
  }
};

}  // namespace gabion::mpm
