// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/LU>

#include "common/mechanics/tensor.hpp"

namespace gabion {

/// Symmetric part of a second-order tensor; in plane strain its zz component is zero.
template <int dim>
Symmetric<dim> symmetric(const Matrix<dim>& m) {
  if constexpr (dim == 2) {
    return {m(0, 0), m(1, 1), 0.0, 0.5 * (m(0, 1) + m(1, 0))};
  } else {
    Symmetric<3> s;
    s << m(0, 0), m(1, 1), m(2, 2), 0.5 * (m(0, 1) + m(1, 0)), 0.5 * (m(1, 2) + m(2, 1)),
        0.5 * (m(0, 2) + m(2, 0));
    return s;
  }
}

/// The components that act on the dim axes: drops zz in plane strain.
template <int dim>
Matrix<dim> in_plane(const Symmetric<dim>& s) {
  Matrix<dim> m;
  if constexpr (dim == 2) {
    m << s[0], s[3], s[3], s[1];
  } else {
    m << s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2];
  }
  return m;
}

/// Sum of the three normal components, zz included in plane strain.
template <int dim>
double trace(const Symmetric<dim>& s) {
  return s[0] + s[1] + s[2];
}

/// Double contraction s : t of two symmetric tensors.
template <int dim>
double contract(const Symmetric<dim>& s, const Symmetric<dim>& t) {
  return s.dot(t) +
         s.template tail<symmetric_size<dim> - 3>().dot(t.template tail<symmetric_size<dim> - 3>());
}

/// det(1 + H) - 1 without the cancellation of the 1.
template <int dim>
double determinant_minus_one(const Matrix<dim>& H) {
  double sum = H.trace() + H.determinant();
  if constexpr (dim == 3) {
    sum += H(0, 0) * H(1, 1) - H(0, 1) * H(1, 0) + H(1, 1) * H(2, 2) - H(1, 2) * H(2, 1) +
           H(0, 0) * H(2, 2) - H(0, 2) * H(2, 0);
  }
  return sum;
}

/// b - 1 after a step, from e_n = b_n - 1 before it: (1 + H) e_n (1 + H)^T + H + H^T + H H^T.
template <int dim>
Symmetric<dim> push_forward(const Matrix<dim>& H, const Symmetric<dim>& e_n) {
  const Matrix<dim> F = Matrix<dim>::Identity() + H;
  const Matrix<dim> Fe = F * in_plane<dim>(e_n);
  const Matrix<dim> e = Fe * F.transpose() + H + H.transpose() + H * H.transpose();
  Symmetric<dim> result = symmetric<dim>(e);
  if constexpr (dim == 2) result[2] = e_n[2];
  return result;
}

/// The e_n that push_forward() by H makes e of.
template <int dim>
Symmetric<dim> pull_back(const Matrix<dim>& H, const Symmetric<dim>& e) {
  const Matrix<dim> F = Matrix<dim>::Identity() + H;
  return push_forward<dim>(-F.inverse() * H, e);
}

/// P = tau (1 + H)^-T.
template <int dim>
Matrix<dim> first_piola(const Symmetric<dim>& tau, const Matrix<dim>& F_inverse) {
  return in_plane<dim>(tau) * F_inverse.transpose();
}

}  // namespace gabion
