// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "common/mechanics/tensor.hpp"
#include "mpm_solver/grid/basis.hpp"

namespace gabion::mpm {

/// f_ia += P_aJ grad_iJ
/// @param n, local, grad  values of a point: their number, each one's node and gradient
template <int dim>
void add_gradients(int n, const std::uint8_t* local, const Matrix<dim>& P, const Vector<dim>* grad,
                   double* f) {
  for (int i = 0; i < n; ++i) {
    double* f_i = f + local[i] * dim;
    for (int a = 0; a < dim; ++a) {
      for (int J = 0; J < dim; ++J) f_i[a] += P(a, J) * grad[i][J];
    }
  }
}

/// Force and stiffness of one cell, added up over its material points.
template <int dim>
struct CellForces {
  static constexpr int max_dofs = max_group_nodes<dim> * dim;
  double f[max_dofs];
  double K[max_dofs * max_dofs];  // row-major, (n dim) x (n dim)

  void set_zero(int n, bool with_K) {
    for (int i = 0; i < n * dim; ++i) f[i] = 0;
    if (!with_K) return;
    for (int i = 0; i < n * dim * n * dim; ++i) K[i] = 0;
  }

  void add_stress(int n, const std::uint8_t* local, const Matrix<dim>& P, const Vector<dim>* grad) {
    add_gradients<dim>(n, local, P, grad, f);
  }

  /// Add the n nodes' forces to a nodal field. @param active  numbers of the nodes in the field
  void scatter(int n, const std::int32_t* active, double* field) const {
    for (int i = 0; i < n; ++i) {
      double* at_node = field + static_cast<std::ptrdiff_t>(active[i]) * dim;
      for (int a = 0; a < dim; ++a) at_node[a] += f[i * dim + a];
    }
  }

  /// K_xy += x y
  void add_product(int num_dofs, const double* x, const double* y) {
    for (int i = 0; i < num_dofs; ++i) {
      for (int k = 0; k < num_dofs; ++k) K[i * num_dofs + k] += x[i] * y[k];
    }
  }

  /// K_(ia)(kb) += grad_iJ A_(aJ)(bL) grad_kL
  /// @param width  number of nodes of the cell
  void add_tangent(int n, const std::uint8_t* local, int width, const Tangent<dim>& A,
                   const Vector<dim>* grad) {
    for (int i = 0; i < n; ++i) {
      double left[dim][dim * dim];  // grad_iJ A_(aJ)(bL)
      for (int a = 0; a < dim; ++a) {
        for (int bL = 0; bL < dim * dim; ++bL) {
          double sum = 0;
          for (int J = 0; J < dim; ++J) sum += grad[i][J] * A(a * dim + J, bL);
          left[a][bL] = sum;
        }
      }
      for (int a = 0; a < dim; ++a) {
        double* row = K + static_cast<std::ptrdiff_t>(local[i] * dim + a) * width * dim;
        for (int k = 0; k < n; ++k) {
          for (int b = 0; b < dim; ++b) {
            double sum = 0;
            for (int L = 0; L < dim; ++L) sum += left[a][b * dim + L] * grad[k][L];
            row[local[k] * dim + b] += sum;
          }
        }
      }
    }
  }
};

}  // namespace gabion::mpm
