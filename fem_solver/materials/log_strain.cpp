// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/materials/log_strain.hpp"

#include <algorithm>
#include <cmath>

namespace gabion::fem {

namespace {

Matrix<2> axes_of(const PlaneAxes& n) {
  double c, s;  // of the single angle, without cancellation
  if (n.cos_2t >= 0) {
    c = std::sqrt(0.5 * (1 + n.cos_2t));
    s = 0.5 * n.sin_2t / c;
  } else {
    s = std::sqrt(0.5 * (1 - n.cos_2t));
    c = 0.5 * n.sin_2t / s;
  }
  Matrix<2> N;
  N << c, -s, s, c;
  return N;
}

const Matrix<3>& axes_of(const Matrix<3>& n) {
  return n;
}

/// Turns StrainVectors to the axes N.
template <int dim>
StrainMatrix<dim> turned(const Matrix<dim>& N) {
  StrainMatrix<dim> R;
  for (int a = 0; a < dim; ++a)
    for (int b = a; b < dim; ++b)
      for (int c = 0; c < dim; ++c)
        for (int d = c; d < dim; ++d)
          R(strain_index<dim>(a, b), strain_index<dim>(c, d)) =
              0.5 * strain_factor(a, b) * strain_factor(c, d) *
              (N(c, a) * N(d, b) + N(c, b) * N(d, a));
  return R;
}

/// Contribution of the rotation of the axes to dS/dE, on the axes: dS_ab = 4 sum_c f2(a, c, b)
/// (T_ac dE_cb + dE_ac T_cb).
template <int dim>
void add_curvature(const std::array<double, dim>& x, const Matrix<dim>& T, StrainMatrix<dim>& D) {
  const auto add = [&](int a, int b, int c, double f2) {
    const double w = 4 * f2 * strain_factor(a, b);
    const int row = strain_index<dim>(a, b);
    D(row, strain_index<dim>(c, b)) += w * T(a, c) / strain_factor(c, b);
    D(row, strain_index<dim>(a, c)) += w * T(c, b) / strain_factor(a, c);
  };
  for (int a = 0; a < dim; ++a)
    for (int b = a; b < dim; ++b)
      for (int c = 0; c < dim; ++c) add(a, b, c, log_curvature(x[a], x[b], x[c]));
}

}  // namespace

double log_curvature(double x, double y, double z) {
  const double m = (x + y + z) / 3;
  const double d[3] = {x - m, y - m, z - m};
  const double widest = std::max({std::abs(d[0]), std::abs(d[1]), std::abs(d[2])}) / m;
  if (widest >= 0.1) {
    double s[3] = {x, y, z};
    std::sort(s, s + 3);
    return (hencky_slope(s[1], s[2]) - hencky_slope(s[0], s[1])) / (s[2] - s[0]);
  }
  // Taylor series about the mean in the complete homogeneous polynomials h_k of d / m, from
  // Newton's identities; sum d = 0, so that e_1 = 0 and h_k = -e_2 h_{k-2} + e_3 h_{k-3}.
  const double e_2 = (d[0] * d[1] + d[1] * d[2] + d[2] * d[0]) / (m * m);
  const double e_3 = d[0] * d[1] * d[2] / (m * m * m);
  double h_3 = 0, h_2 = 0, h_1 = 1;  // h_{k-3}, h_{k-2}, h_{k-1} of the next k = 1
  double sum = -0.5;
  constexpr int last = 14;  // the next term is below 1e-15 of the sum
  for (int k = 1; k <= last; ++k) {
    const double h = -e_2 * h_2 + e_3 * h_3;
    sum += (k % 2 == 0 ? -h : h) / (k + 2);
    h_3 = h_2;
    h_2 = h_1;
    h_1 = h;
  }
  return 0.5 * sum / (m * m);
}

template <int dim>
bool find_log_strain(const Matrix<dim>& twice_E, LogStrain<dim>& out) {
  const Eigenpairs<dim> pairs = eigenpairs<dim>(symmetric<dim>(twice_E));
  std::array<double, 3> logarithms{};
  for (int i = 0; i < dim; ++i) {
    if (!(pairs.value[i] > -1)) return false;
    out.stretch_2[i] = 1 + pairs.value[i];
    logarithms[i] = hencky_strain(pairs.value[i]);
  }
  out.N = axes_of(pairs.n);
  out.E = compose<dim>(logarithms, pairs.n);
  return true;
}

template <int dim>
LogStrain<dim> log_strain_of(const Symmetric<dim>& E) {
  const Eigenpairs<dim> pairs = eigenpairs<dim>(E);
  LogStrain<dim> strain;
  strain.E = E;
  for (int i = 0; i < dim; ++i) strain.stretch_2[i] = 1 + strain_from_hencky(pairs.value[i]);
  strain.N = axes_of(pairs.n);
  return strain;
}

template <int dim>
Matrix<dim> stretch(const LogStrain<dim>& strain, int exponent) {
  Vector<dim> values;
  for (int i = 0; i < dim; ++i) values[i] = std::pow(strain.stretch_2[i], 0.5 * exponent);
  return strain.N * values.asDiagonal() * strain.N.transpose();
}

template <int dim>
StrainMatrix<dim> log_by_green(const LogStrain<dim>& strain) {
  const StrainMatrix<dim> R = turned<dim>(strain.N);
  StrainVector<dim> slopes;
  for (int a = 0; a < dim; ++a)
    for (int b = a; b < dim; ++b)
      slopes[strain_index<dim>(a, b)] = 2 * hencky_slope(strain.stretch_2[a], strain.stretch_2[b]);
  return R.transpose() * (slopes.asDiagonal() * R).eval();
}

template <int dim>
GreenStress<dim> turned_to_green(const LogStrain<dim>& strain, const StrainMatrix<dim>& slopes,
                                 const LogStress<dim>& stress, bool with_tangent) {
  GreenStress<dim> green;
  const Matrix<dim> T = in_plane<dim>(stress.T);
  green.S.noalias() = slopes * strain_vector<dim>(T);
  if (!with_tangent) return green;
  const StrainMatrix<dim> R = turned<dim>(strain.N);
  StrainMatrix<dim> curvature = StrainMatrix<dim>::Zero();
  add_curvature<dim>(strain.stretch_2, strain.N.transpose() * T * strain.N, curvature);
  green.D.noalias() = slopes * (stress.D * slopes).eval();
  green.D.noalias() += R.transpose() * (curvature * R).eval();
  return green;
}

template bool find_log_strain<2>(const Matrix<2>&, LogStrain<2>&);
template bool find_log_strain<3>(const Matrix<3>&, LogStrain<3>&);
template Matrix<2> stretch<2>(const LogStrain<2>&, int);
template Matrix<3> stretch<3>(const LogStrain<3>&, int);
template LogStrain<2> log_strain_of<2>(const Symmetric<2>&);
template LogStrain<3> log_strain_of<3>(const Symmetric<3>&);
template StrainMatrix<2> log_by_green<2>(const LogStrain<2>&);
template StrainMatrix<3> log_by_green<3>(const LogStrain<3>&);
template GreenStress<2> turned_to_green<2>(const LogStrain<2>&, const StrainMatrix<2>&,
                                           const LogStress<2>&, bool);
template GreenStress<3> turned_to_green<3>(const LogStrain<3>&, const StrainMatrix<3>&,
                                           const LogStress<3>&, bool);

}  // namespace gabion::fem
