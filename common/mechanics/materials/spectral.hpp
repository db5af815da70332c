// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cmath>
#include <type_traits>

#include "common/mechanics/tensor_functions.hpp"

namespace gabion {

/// artanh(s) / s for |s| < 1, smooth at 0.
inline double artanh_ratio(double s) {
  if (std::abs(s) > 1.0 / 16) return std::atanh(s) / s;
  const double q = s * s;  // the first term left out is q^7 / 15 < 3e-18
  return 1 + q * (1.0 / 3 +
                  q * (1.0 / 5 + q * (1.0 / 7 + q * (1.0 / 9 + q * (1.0 / 11 + q * (1.0 / 13))))));
}

/// Hencky strain ln(1 + e) / 2 of a principal value e = b - 1 > -1, to rounding for every size of
/// e.
inline double hencky_strain(double e) {
  const double s = e / (2 + e);
  return std::abs(s) > 1.0 / 16 ? 0.5 * std::log1p(e) : s * artanh_ratio(s);
}

/// Inverse of hencky_strain: exp(2 eps) - 1.
inline double strain_from_hencky(double eps) {
  const double x = 2 * eps;
  if (std::abs(x) > 1.0 / 16) return std::expm1(x);
  // the first term left out is x^9 / 10! < 4e-18 of x
  constexpr double c[] = {1.0,       1.0 / 2,    1.0 / 6,     1.0 / 24,    1.0 / 120,
                          1.0 / 720, 1.0 / 5040, 1.0 / 40320, 1.0 / 362880};
  double sum = c[8];
  for (int i = 7; i >= 0; --i) sum = c[i] + x * sum;
  return x * sum;
}

/// (eps_i - eps_j) / (b_i - b_j) of Hencky strains, with its limit 1 / (2 b) at b_i = b_j.
inline double hencky_slope(double b_i, double b_j) {
  const double sum = b_i + b_j;
  const double s = (b_i - b_j) / sum;
  if (std::abs(s) > 0.5) return 0.5 * std::log(b_i / b_j) / (b_i - b_j);
  return artanh_ratio(s) / sum;
}

/// Two orthonormal axes n_0 = (cos t, sin t), n_1 = (-sin t, cos t) by their double angle.
struct PlaneAxes {
  double cos_2t = 1;
  double sin_2t = 0;
};

/// Orthonormal axes; in 3D the columns of a matrix.
template <int dim>
using Axes = std::conditional_t<dim == 2, PlaneAxes, Eigen::Matrix3d>;

/// n_i (x) n_j
inline Matrix<2> dyad(const PlaneAxes& n, int i, int j) {
  const double half_cos = 0.5 * n.cos_2t, half_sin = 0.5 * n.sin_2t;
  Matrix<2> m;
  if (i == j) {
    const double sign = i == 0 ? 1 : -1;
    m << 0.5 + sign * half_cos, sign * half_sin, sign * half_sin, 0.5 - sign * half_cos;
  } else {
    const double spin = i == 0 ? 0.5 : -0.5;
    m << -half_sin, half_cos + spin, half_cos - spin, half_sin;
  }
  return m;
}
inline Matrix<3> dyad(const Eigen::Matrix3d& n, int i, int j) {
  return n.col(i) * n.col(j).transpose();
}

/// Eigenvalues and axes of a symmetric tensor. In plane strain value[0] >= value[1] lie in the
/// plane and value[2] belongs to the out-of-plane axis.
template <int dim>
struct Eigenpairs {
  std::array<double, 3> value;
  Axes<dim> n;
};

/// Eigenpairs, orthogonal to rounding also for equal or nearly equal values.
template <int dim>
Eigenpairs<dim> eigenpairs(const Symmetric<dim>& s);

/// sum_i value_i n_i (x) n_i
template <int dim>
Symmetric<dim> compose(const std::array<double, 3>& value, const Axes<dim>& n);

/// Derivative of the principal Kirchhoff stresses and shear factors of an isotropic law. In plane
/// strain only the pair 01 of G is used.
struct PrincipalModuli {
  Eigen::Matrix3d D;  ///< D(i, j) = d tau_i / d eps_j, eps the trial Hencky strain
  Eigen::Vector3d G;  ///< (tau_i - tau_j) / (b_i - b_j) at pair_index(i, j), with limit if equal
};

/// Position of the pair i < j among 01, 12, 02.
constexpr int pair_index(int i, int j) {
  return j - i == 2 ? 2 : i;
}

/// Moduli of tau = lambda tr(eps) 1 + 2 mu eps at b_i = 1 + value_i.
template <int dim>
PrincipalModuli hencky_moduli(double lambda, double mu, const std::array<double, 3>& value) {
  PrincipalModuli moduli;
  moduli.D.setConstant(lambda);
  moduli.D.diagonal().array() += 2 * mu;
  moduli.G.setZero();
  for (int i = 0; i < dim; ++i)
    for (int j = i + 1; j < dim; ++j)
      moduli.G[pair_index(i, j)] = 2 * mu * hencky_slope(1 + value[i], 1 + value[j]);
  return moduli;
}

template <>
inline Eigenpairs<2> eigenpairs<2>(const Symmetric<2>& s) {
  const double mean = 0.5 * (s[0] + s[1]);
  const double half = 0.5 * (s[0] - s[1]);
  const double radius = std::sqrt(half * half + s[3] * s[3]);
  Eigenpairs<2> pairs;
  pairs.value = {mean + radius, mean - radius, s[2]};
  if (radius > 0) pairs.n = {half / radius, s[3] / radius};
  return pairs;
}

template <>
inline Symmetric<2> compose<2>(const std::array<double, 3>& value, const PlaneAxes& n) {
  const double mean = 0.5 * (value[0] + value[1]);
  const double radius = 0.5 * (value[0] - value[1]);
  return {mean + radius * n.cos_2t, mean - radius * n.cos_2t, value[2], radius * n.sin_2t};
}

template <>
Eigenpairs<3> eigenpairs<3>(const Symmetric<3>& s);
template <>
Symmetric<3> compose<3>(const std::array<double, 3>& value, const Eigen::Matrix3d& n);

/// dP/dH of an isotropic law at trial eigenpairs b_i = 1 + value_i, n_i:
///
///     A_iJkL = F^-1_Ja a_iakb F^-1_Lb,   a : l = d tau - tau l^T,   l = dF F^-1
///
/// with, on the axes n_i, a_iijj = D_ij - tau_i delta_ij and for i != j
/// a_ijij = G_ij b_j, a_ijji = G_ij b_i - tau_i.
template <int dim>
void spectral_tangent(const PrincipalModuli& moduli, const std::array<double, 3>& tau,
                      const Eigenpairs<dim>& trial, const Matrix<dim>& F_inverse, Tangent<dim>& A) {
  // A = left^T right; row (i, j) of left is n_i (x) F^-1 n_j as a row-major list, right = a left
  Tangent<dim> left, right;
  const Matrix<dim> F_inverse_T = F_inverse.transpose();
  for (int i = 0; i < dim; ++i) {
    for (int j = 0; j < dim; ++j) {
      const Matrix<dim> m = dyad(trial.n, i, j) * F_inverse_T;
      for (int c = 0; c < dim * dim; ++c) left(i * dim + j, c) = m(c / dim, c % dim);
    }
  }
  const auto row = [](int i, int j) { return i * dim + j; };
  for (int i = 0; i < dim; ++i) {
    right.row(row(i, i)) = -tau[i] * left.row(row(i, i));
    for (int j = 0; j < dim; ++j) right.row(row(i, i)) += moduli.D(i, j) * left.row(row(j, j));
    for (int j = i + 1; j < dim; ++j) {
      const double G = moduli.G[pair_index(i, j)];
      const double b_i = 1 + trial.value[i], b_j = 1 + trial.value[j];
      // G b_i - tau_i = G b_j - tau_j; the mean stays symmetric for a G that is not the quotient
      const double mixed = 0.5 * (G * (b_i + b_j) - (tau[i] + tau[j]));
      right.row(row(i, j)) = G * b_j * left.row(row(i, j)) + mixed * left.row(row(j, i));
      right.row(row(j, i)) = mixed * left.row(row(i, j)) + G * b_i * left.row(row(j, i));
    }
  }
  A.noalias() = left.transpose().lazyProduct(right);
}

/// Spectral tangent in plane strain, on the basis 1, d = n_0 n_0 - n_1 n_1, q = n_0 n_1 + n_1 n_0
/// and the spin w = n_0 n_1 - n_1 n_0, of which only d and q depend on the axes, and q = -w d:
///
///     4 a = 1 (x) u + d (x) v + q (x) y + w (x) z ,   u, v in span(1, d),   y, z in span(q, w)
template <>
inline void spectral_tangent<2>(const PrincipalModuli& moduli, const std::array<double, 3>& tau,
                                const Eigenpairs<2>& trial, const Matrix<2>& F_inverse,
                                Tangent<2>& A) {
  const Eigen::Matrix3d& D = moduli.D;
  const double D00 = D(0, 0) - tau[0], D11 = D(1, 1) - tau[1];
  const double b_0 = 1 + trial.value[0], b_1 = 1 + trial.value[1], G = moduli.G[0];
  const double sum_b = G * (b_0 + b_1), difference_b = G * (b_1 - b_0);
  const double twice_mixed = sum_b - (tau[0] + tau[1]);  // see the general case
  const double cos_2t = trial.n.cos_2t, sin_2t = trial.n.sin_2t;

  using Row = Eigen::Matrix<double, 1, 4>;
  const Eigen::RowVector2d f_0 = 0.5 * F_inverse.col(0).transpose();  // rows of F^-T / 2
  const Eigen::RowVector2d f_1 = 0.5 * F_inverse.col(1).transpose();
  const Eigen::RowVector2d d_0 = cos_2t * f_0 + sin_2t * f_1, d_1 = sin_2t * f_0 - cos_2t * f_1;
  const Row one = (Row() << f_0, f_1).finished(), d = (Row() << d_0, d_1).finished();
  const Row q = (Row() << -d_1, d_0).finished(), w = (Row() << f_1, -f_0).finished();
  const Row u = (D00 + D(0, 1) + D(1, 0) + D11) * one + (D00 - D(0, 1) + D(1, 0) - D11) * d;
  const Row v = (D00 + D(0, 1) - D(1, 0) - D11) * one + (D00 - D(0, 1) - D(1, 0) + D11) * d;
  const Row y = (sum_b + twice_mixed) * q + difference_b * w;
  const Row z = difference_b * q + (sum_b - twice_mixed) * w;
  const Row stretch = cos_2t * v - sin_2t * y, shear = sin_2t * v + cos_2t * y;
  const Row u_plus = u + stretch, u_minus = u - stretch;
  const Row z_plus = shear + z, z_minus = shear - z;
  for (int J = 0; J < 2; ++J) {
    A.row(J) = f_0[J] * u_plus + f_1[J] * z_plus;
    A.row(2 + J) = f_0[J] * z_minus + f_1[J] * u_minus;
  }
}

}  // namespace gabion
