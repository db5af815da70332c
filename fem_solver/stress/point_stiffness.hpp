// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/mechanics/tensor.hpp"

namespace gabion::fem {

/// K_ab += w dN_a . A . dN_b, row-major (nodes dim) x (nodes dim).
template <int dim, int nodes>
void add_point_stiffness(const Tangent<dim>& A, const Vector<dim>* dN, double w, double* K) {
  constexpr int n = nodes * dim;
  for (int b = 0; b < nodes; ++b) {
    double AdN[dim * dim][dim];  // (iJ, k) = w A(iJ, kL) dN_b,L
    for (int iJ = 0; iJ < dim * dim; ++iJ) {
      for (int k = 0; k < dim; ++k) {
        double sum = 0;
        for (int L = 0; L < dim; ++L) sum += A(iJ, k * dim + L) * dN[b][L];
        AdN[iJ][k] = w * sum;
      }
    }
    for (int a = 0; a < nodes; ++a) {
      for (int i = 0; i < dim; ++i) {
        double* row = K + (a * dim + i) * n + b * dim;
        for (int k = 0; k < dim; ++k) {
          double sum = 0;
          for (int J = 0; J < dim; ++J) sum += dN[a][J] * AdN[i * dim + J][k];
          row[k] += sum;
        }
      }
    }
  }
}

}  // namespace gabion::fem
