// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <numbers>

#include "common/mechanics/tensor_functions.hpp"

namespace gabion::fem {

/// Number of components of a strain that acts on the dim axes.
template <int dim>
inline constexpr int strain_size = dim == 2 ? 3 : 6;

/// Symmetric tensor on the dim axes as a vector whose products are those of the tensors: 2D xx, yy,
/// r xy; 3D xx, yy, zz, r xy, r yz, r xz with r = sqrt(2) (Mandel).
template <int dim>
using StrainVector = Eigen::Matrix<double, strain_size<dim>, 1>;
template <int dim>
using StrainMatrix = Eigen::Matrix<double, strain_size<dim>, strain_size<dim>>;

/// Place of the components ab and ba in a StrainVector.
template <int dim>
constexpr int strain_index(int a, int b) {
  constexpr int places[3][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}};
  return dim == 2 ? (a == b ? a : 2) : places[a][b];
}

/// Factor between the component ab of a tensor and that of its StrainVector.
constexpr double strain_factor(int a, int b) {
  return a == b ? 1 : std::numbers::sqrt2;
}

template <int dim>
StrainVector<dim> strain_vector(const Matrix<dim>& s) {
  StrainVector<dim> v;
  for (int a = 0; a < dim; ++a)
    for (int b = a; b < dim; ++b) v[strain_index<dim>(a, b)] = strain_factor(a, b) * s(a, b);
  return v;
}

template <int dim>
Matrix<dim> strain_tensor(const StrainVector<dim>& v) {
  Matrix<dim> s;
  for (int a = 0; a < dim; ++a)
    for (int b = 0; b < dim; ++b) s(a, b) = v[strain_index<dim>(a, b)] / strain_factor(a, b);
  return s;
}

/// Response of a law to the Green strain E = (C - 1) / 2.
template <int dim>
struct GreenStress {
  StrainVector<dim> S;  ///< second Piola-Kirchhoff stress [Pa]
  StrainMatrix<dim> D;  ///< dS/dE [Pa]
};

/// 2 E = C - 1 = H + H^T + H^T H.
template <int dim>
Matrix<dim> twice_green_strain(const Matrix<dim>& H) {
  return H + H.transpose() + H.transpose() * H;
}

/// Derivative of E by F = 1 + H: rows as in a Tangent, (i, J).
template <int dim>
using StrainByGradient = Eigen::Matrix<double, dim * dim, strain_size<dim>, Eigen::RowMajor>;

template <int dim>
StrainByGradient<dim> strain_by_gradient(const Matrix<dim>& F) {
  StrainByGradient<dim> B = StrainByGradient<dim>::Zero();
  for (int i = 0; i < dim; ++i)
    for (int J = 0; J < dim; ++J)
      for (int M = 0; M < dim; ++M)
        B(i * dim + J, strain_index<dim>(M, J)) += F(i, M) / strain_factor(M, J);
  return B;
}

/// A_iJkL = delta_ik S_JL + F_iM D_MJLN F_kN, the derivative of P = F S by F.
template <int dim>
void first_tangent(const Matrix<dim>& F, const GreenStress<dim>& green, Tangent<dim>& A) {
  const StrainByGradient<dim> B = strain_by_gradient<dim>(F);
  const StrainByGradient<dim> BD = B * green.D;
  A.noalias() = BD * B.transpose();
  const Matrix<dim> S = strain_tensor<dim>(green.S);
  for (int i = 0; i < dim; ++i)
    for (int J = 0; J < dim; ++J)
      for (int L = 0; L < dim; ++L) A(i * dim + J, i * dim + L) += S(J, L);
}

}  // namespace gabion::fem
