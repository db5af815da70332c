// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/stress/shell_strain.hpp"

#include <Eigen/LU>
#include <cmath>
#include <utility>

namespace gabion::fem {

namespace {

/// The reference axes, thickness last, in cyclic order.
std::array<int, 3> axes_of(int thickness) {
  return {(thickness + 1) % 3, (thickness + 2) % 3, thickness};
}

/// Point of the reference cell from its coordinates in the plane of the shell and across.
Vector<3> point_at(const std::array<int, 3>& axes, double r, double s, double t) {
  Vector<3> xi;
  xi[axes[0]] = r;
  xi[axes[1]] = s;
  xi[axes[2]] = t;
  return xi;
}

std::array<Vector<3>, 8> slopes_at(const Vector<3>& xi) {
  ShapeValues<3> shape;
  shape_functions<CellType::hex8>(xi, shape);
  std::array<Vector<3>, 8> slopes;
  for (int a = 0; a < 8; ++a) slopes[a] = shape.dN[a];
  return slopes;
}

/// Coordinate and weight of each point across; weights sum to 2.
std::vector<std::pair<double, double>> rule_across(int across) {
  if (across == elastic_points_across) return {{-std::sqrt(1.0 / 3), 1}, {std::sqrt(1.0 / 3), 1}};
  std::vector<std::pair<double, double>> rule;
  for (const double middle : {-0.5, 0.5}) {  // three points in each half
    for (const auto& [t, w] :
         {std::pair(-std::sqrt(0.6), 5.0 / 9), {0.0, 8.0 / 9}, {std::sqrt(0.6), 5.0 / 9}}) {
      rule.emplace_back(middle + 0.5 * t, 0.5 * w);
    }
  }
  return rule;
}

constexpr double corner_signs[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};

/// Row alpha is dx / dxi_alpha.
Matrix<3> jacobian(const std::array<Vector<3>, 8>& slopes, std::span<const Vector<3>> x) {
  Matrix<3> J = Matrix<3>::Zero();
  for (int a = 0; a < 8; ++a) J += slopes[a] * x[a].transpose();
  return J;
}

/// StrainVector of e to that of A e A^T.
StrainMatrix<3> turned_by(const Matrix<3>& A) {
  StrainMatrix<3> R;
  for (int a = 0; a < 3; ++a)
    for (int b = a; b < 3; ++b)
      for (int c = 0; c < 3; ++c)
        for (int d = c; d < 3; ++d)
          R(strain_index<3>(a, b), strain_index<3>(c, d)) = 0.5 * strain_factor(a, b) *
                                                            strain_factor(c, d) *
                                                            (A(a, c) * A(b, d) + A(a, d) * A(b, c));
  return R;
}

/// Polynomials of the modes and the tensor that each multiplies, on the reference axes.
struct ReferenceModes {
  std::array<double, num_shell_modes> values;
  std::array<std::array<int, 2>, num_shell_modes> components;
};

ReferenceModes reference_modes(const std::array<int, 3>& axes, const Vector<3>& xi) {
  const auto [one, two, three] = axes;
  const double r = xi[one], s = xi[two], t = xi[three];
  return {.values = {r, s, r, s, t, r * t, s * t},
          .components = {{{one, one},
                          {two, two},
                          {one, two},
                          {one, two},
                          {three, three},
                          {three, three},
                          {three, three}}}};
}

}  // namespace

ShellRule::ShellRule(int axis, int across) {
  const auto axes = axes_of(axis);
  for (const auto& [r, s] : {std::pair(0, -1), {0, 1}, {-1, 0}, {1, 0}}) {
    slopes.push_back(slopes_at(point_at(axes, r, s, 0)));
  }
  for (const auto& [r, s] : corner_signs) slopes.push_back(slopes_at(point_at(axes, r, s, 0)));
  const double in_plane = std::sqrt(1.0 / 3);
  for (const auto& [t, weight] : rule_across(across)) {
    for (const auto& [sign_r, sign_s] : corner_signs) {
      const double r = sign_r * in_plane, s = sign_s * in_plane;
      const int own = static_cast<int>(slopes.size());
      points.push_back({.xi = point_at(axes, r, s, t), .weight = weight});
      slopes.push_back(slopes_at(points.back().xi));
      const auto [one, two, three] = axes;
      std::array<Term, num_terms> of_point = {{{one, one, own, 1},
                                               {two, two, own, 1},
                                               {one, two, own, 1},
                                               {one, three, 0, 0.5 * (1 - s)},
                                               {one, three, 1, 0.5 * (1 + s)},
                                               {two, three, 2, 0.5 * (1 - r)},
                                               {two, three, 3, 0.5 * (1 + r)}}};
      for (int k = 0; k < 4; ++k) {
        const auto& [corner_r, corner_s] = corner_signs[k];
        of_point[7 + k] = {three, three, 4 + k, 0.25 * (1 + corner_r * r) * (1 + corner_s * s)};
      }
      terms.push_back(of_point);
    }
  }
}

ShellShape shell_shape(const ShellRule& rule, int axis, std::span<const Vector<3>> x) {
  ShellShape shape;
  for (int a = 0; a < 8; ++a) shape.x[a] = x[a];
  const auto axes = axes_of(axis);
  const Matrix<3> J_0 = jacobian(slopes_at(Vector<3>::Zero()), x);
  const Matrix<3> J_0_inverse = J_0.inverse();
  for (std::size_t q = 0; q < rule.points.size(); ++q) {
    const Matrix<3> J = jacobian(rule.slopes[ShellRule::num_ties + q], x);
    shape.axes.push_back(turned_by(J.inverse()));
    const ReferenceModes modes = reference_modes(axes, rule.points[q].xi);
    ShellModes M;
    for (int m = 0; m < num_shell_modes; ++m) {  // strains of unit size, whatever that of the cell
      const auto [i, j] = modes.components[m];
      Matrix<3> tensor = 0.5 * (J_0_inverse.col(i) * J_0_inverse.col(j).transpose() +
                                J_0_inverse.col(j) * J_0_inverse.col(i).transpose());
      tensor.normalize();
      M.col(m) = J_0.determinant() / J.determinant() * modes.values[m] * strain_vector<3>(tensor);
    }
    shape.modes.push_back(M);
  }
  return shape;
}

}  // namespace gabion::fem
