// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/boulders/ellipsoid.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/error.hpp"

namespace gabion::mpm {

namespace {

constexpr int most_iterations = 100, most_halvings = 30;
// Newton's method on the sphere of directions: steps are at most this long, below the second number
// they need no check, and the one below the third is the last one, since the next would be
// rounding.
constexpr double longest_step = 0.5, sure_step = 1e-5, last_step = 1e-8;

// The direction from the place of an ellipsoid that is nearest to y, in its axes (Eberly 2013,
// "Distance from a point to an ellipse, an ellipsoid, or a hyperellipsoid"): y_i / (a_i^2 + t) with
// the largest root t of sum (a_i y_i / (a_i^2 + t))^2 = 1. The inverse of the root of that sum is
// concave in t, so Newton's method for it rises to the root from below.
template <int dim>
Vector<dim> nearest_normal(const Vector<dim>& axes, const Vector<dim>& y) {
  const Vector<dim> squares = axes.cwiseAbs2(), ay = axes.cwiseProduct(y.cwiseAbs());
  double t = (ay - squares).maxCoeff();
  double sum = 0;
  for (int k = 0; k < most_iterations; ++k) {
    double slope = 0;
    sum = 0;
    for (int i = 0; i < dim; ++i) {
      if (ay[i] == 0) continue;
      const double q = ay[i] / (squares[i] + t);
      sum += q * q;
      slope += q * q / (squares[i] + t);
    }
    if (sum <= 1) break;
    const double next = t + sum * (std::sqrt(sum) - 1) / slope;
    if (!(next > t)) break;
    t = next;
  }
  Vector<dim> normal;
  for (int i = 0; i < dim; ++i) normal[i] = ay[i] == 0 ? 0 : y[i] / (squares[i] + t);
  int shortest = 0;
  squares.minCoeff(&shortest);
  // On the plane of symmetry, deeper than the radius of curvature: two places are nearest.
  if (ay[shortest] == 0 && t == -squares[shortest] && sum < 1) {
    normal[shortest] = std::sqrt(1 - sum) / axes[shortest];
  }
  return normal.normalized();
}

}  // namespace

Ellipsoid::Ellipsoid(const Vector<3>& centre, const Eigen::Quaterniond& turned,
                     const Vector<3>& axes)
    : centre_(centre), turned_(turned.toRotationMatrix()), axes_(axes) {
  if (axes_[2] == 0) axes_[2] = axes_.maxCoeff();
}

Vector<3> Ellipsoid::arm(const Vector<3>& n) const {
  const Vector<3> s = stretched(n);
  return turned_ * axes_.cwiseProduct(s) / s.norm();
}

Matrix<3> Ellipsoid::squares() const {
  return turned_ * axes_.cwiseAbs2().asDiagonal() * turned_.transpose();
}

Matrix<3> Ellipsoid::curvature_radii(const Vector<3>& n) const {
  const Vector<3> s = arm(n);
  return (squares() - s * s.transpose()) / extent(n);
}

EllipsoidGap Ellipsoid::to_plane(const Vector<3>& x, const Vector<3>& n) const {
  return {.gap = n.dot(centre_ - x) - extent(n), .out = -n};
}

EllipsoidGap Ellipsoid::to_point(const Vector<3>& x) const {
  const Vector<3> d = x - centre_;
  const Vector<3> out = turned_ * nearest_normal<3>(axes_, turned_.transpose() * d);
  return {.gap = out.dot(d) - extent(out), .out = out};
}

// Along the line the ellipsoid is an ellipse, with A of the two directions across the line.
EllipsoidGap Ellipsoid::to_line(const Vector<3>& x, const Vector<3>& edge) const {
  Eigen::Matrix<double, 3, 2> across;
  across.col(0) = edge.unitOrthogonal();
  across.col(1) = edge.cross(across.col(0));
  const Eigen::Matrix<double, 3, 2> stretch =
      axes_.asDiagonal() * (turned_.transpose() * across).eval();
  Eigen::SelfAdjointEigenSolver<Matrix<2>> ellipse;
  ellipse.computeDirect(Matrix<2>(stretch.transpose() * stretch));
  const Vector<3> d = x - centre_;
  const Eigen::Matrix<double, 3, 2> axes = across * ellipse.eigenvectors();
  const Vector<3> out =
      axes * nearest_normal<2>(ellipse.eigenvalues().cwiseSqrt(), Vector<2>(axes.transpose() * d));
  return {.gap = out.dot(d) - extent(out), .out = out};
}

// The better one of the direction of the centres and of the normal there of one ellipsoid of A + B.
Vector<3> Ellipsoid::first_normal(const Ellipsoid& other) const {
  const Vector<3> d = other.centre_ - centre_;
  if (d.isZero(0)) return turned_.col(0);
  std::array<Vector<3>, 2> normals = {
      d.normalized(), Vector<3>((squares() + other.squares()).inverse() * d).normalized()};
  const auto gap = [&](const Vector<3>& n) { return n.dot(d) - extent(n) - other.extent(n); };
  return gap(normals[0]) > gap(normals[1]) ? normals[0] : normals[1];
}

EllipsoidGap Ellipsoid::to(const Ellipsoid& other) const {
  const Vector<3> d = other.centre_ - centre_;
  const auto gap = [&](const Vector<3>& n) { return n.dot(d) - extent(n) - other.extent(n); };
  Vector<3> n = first_normal(other);
  for (int k = 0; k < most_iterations; ++k) {
    // In the plane the second direction is that across it.
    const Vector<3> u = n[2] == 0 ? Vector<3>(-n[1], n[0], 0) : n.unitOrthogonal();
    Eigen::Matrix<double, 3, 2> tangents;
    tangents << u, n.cross(u);
    const double now = gap(n);
    const Vector<2> slope = tangents.transpose() * (d - arm(n) - other.arm(n));
    const Matrix<2> radii =
        tangents.transpose() * (curvature_radii(n) + other.curvature_radii(n)) * tangents;
    Matrix<2> bend = radii + now * Matrix<2>::Identity();
    if (!(bend.determinant() > 0 && bend.trace() > 0)) bend = radii;
    Vector<3> step = tangents * (bend.inverse() * slope);
    step *= std::min(1.0, longest_step / step.norm());
    Vector<3> next = (n + step).normalized();
    if (step.norm() < last_step) return {.gap = gap(next), .out = next};
    for (int i = 0; i < most_halvings && step.norm() > sure_step && gap(next) <= now; ++i) {
      step *= 0.5;
      next = (n + step).normalized();
    }
    n = next;
  }
  throw ConvergenceError("the common normal of two ellipsoids is not found", "boulders");
}

}  // namespace gabion::mpm
