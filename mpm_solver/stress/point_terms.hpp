// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <utility>

#include "common/mechanics/materials/point_batch.hpp"

namespace gabion::mpm {

/// Terms of one point in its cell, in the order in which they are summed up there.
/// @tparam dim, num_fields  of space; of the vectors that nodes get
template <int dim, int num_fields>
struct PointTerms {
  static constexpr int num_entries = dim * dim;
  /// Numbers of all fields at a node; a single vector of space is filled up to four.
  static constexpr int width = dim == 3 && num_fields == 1 ? 4 : num_fields * dim;

  /// A node gets sum_J nodal[J] grad_iJ of each field.
  double nodal[dim][width] = {};
  /// Node blocks of the stiffness, each column by column: K_(ia)(kb) gets sum_JL A[J dim + L]_(ab)
  /// grad_iJ grad_kL.
  double A[num_entries * num_entries];

  /// A node gets P grad_i in its first field.
  void set_stress(const Matrix<dim>& P) {
    for (int J = 0; J < dim; ++J) {
      for (int a = 0; a < dim; ++a) nodal[J][a] = P(a, J);
    }
  }
  void set_tangent(const Tangent<dim>& tangent) {
    double* to = A;
    for (int J = 0; J < dim; ++J) {
      for (int L = 0; L < dim; ++L) {
        for (int b = 0; b < dim; ++b) {
          for (int a = 0; a < dim; ++a) *to++ = tangent(a * dim + J, b * dim + L);
        }
      }
    }
  }
};

/// Store component(k) of four points, k < count, at to + k, to + stride + k, ...
template <int count, class Component>
inline void spread(const Component& component, double* to, std::ptrdiff_t stride) {
  const auto four = [&]<std::size_t... q>(std::index_sequence<q...>) {
    const auto store = [&](int k, const LaneBlock& block) {
      block.store(to + k, to + stride + k, to + 2 * stride + k, to + 3 * stride + k);
    };
    (store(4 * q,
           {{component(4 * q), component(4 * q + 1), component(4 * q + 2), component(4 * q + 3)}}),
     ...);
  };
  four(std::make_index_sequence<count / num_lanes>());
  for (int k = count - count % num_lanes; k < count; ++k) {
    const Lanes x = component(k);
    for (int l = 0; l < num_lanes; ++l) to[l * stride + k] = x[l];
  }
}

/// Store the stresses of four points. @param P  row by row
template <int dim>
void spread_stress(const Lanes* P, PointTerms<dim, 1>* to) {
  constexpr int width = PointTerms<dim, 1>::width;
  const auto ordered = [P](int k) {
    const int J = k / width, a = k % width;
    return a < dim ? P[a * dim + J] : Lanes{};
  };
  spread<dim * width>(ordered, to[0].nodal[0], sizeof *to / sizeof(double));
}

/// Store the stiffness of four points. @param A  in the order of Tangent
template <int dim, int num_fields>
void spread_tangent(const Lanes* A, PointTerms<dim, num_fields>* to) {
  constexpr int n = dim * dim;
  const auto ordered = [A](int k) {
    const int J = k / n / dim, L = k / n % dim, b = k % n / dim, a = k % n % dim;
    return A[(a * dim + J) * n + b * dim + L];
  };
  spread<n * n>(ordered, to[0].A, sizeof *to / sizeof(double));
}

}  // namespace gabion::mpm
