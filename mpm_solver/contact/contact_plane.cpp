// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/contact_plane.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "mpm_solver/contact/contact_frame.hpp"

namespace gabion::mpm {

namespace {

// Weight of |phi_n|^2 beside the squares of the regression.
constexpr double regularisation = 1e-4;

// |phi_n| at which the regression begins.
constexpr double first_steepness = 5;

// Steepness of the soft margins, one after the other: the last one sees the nearest points alone.
constexpr double steepness[] = {20, 250, 3000};

constexpr int most_steps = 30;
constexpr int most_halvings = 8;

// Changes below these count as none: of the regression's plane, at which the search for the widest
// margin begins, and of the normal with that margin.
constexpr double small_change = 1e-3;
constexpr double small_turn = 1e-7;

// Points with a smaller weight in a soft end than exp of this count for nothing.
constexpr double least_exponent = -40;

template <int dim>
using Plane = Eigen::Matrix<double, dim + 1, 1>;  // Coefficients (phi_n, phi_0) of a plane.

template <int dim>
struct Regression {
  double sum = 0;
  Plane<dim> gradient = Plane<dim>::Zero();
  Eigen::Matrix<double, dim + 1, dim + 1> normal_matrix =
      Eigen::Matrix<double, dim + 1, dim + 1>::Zero();

  // Sums of squares of 2 / (1 + exp(-z)) - 1 - c, z = phi_n . x + phi_0.
  Regression(const TwoClouds<dim>& clouds, const Plane<dim>& phi) {
    add(clouds.first, -1, phi);
    add(clouds.second, 1, phi);
    sum += regularisation * phi.template head<dim>().squaredNorm();
    gradient.template head<dim>() += regularisation * phi.template head<dim>();
    normal_matrix.diagonal().template head<dim>().array() += regularisation;
  }
  void add(std::span<const Vector<dim>> points, double c, const Plane<dim>& phi) {
    for (const Vector<dim>& x : points) {
      Plane<dim> X;
      X << x, 1;
      const double value = std::tanh(0.5 * X.dot(phi)), r = value - c;
      const Plane<dim> slope = 0.5 * (1 - value * value) * X;
      sum += r * r;
      gradient += r * slope;
      normal_matrix += slope * slope.transpose();
    }
  }
};

// Levenberg's method.
template <int dim>
Vector<dim> logistic_normal(const TwoClouds<dim>& clouds, const Vector<dim>& guess) {
  Plane<dim> phi;
  const auto mean = [&](std::span<const Vector<dim>> points) {
    double sum = 0;
    for (const Vector<dim>& x : points) sum += guess.dot(x);
    return sum / static_cast<double>(points.size());
  };
  phi << first_steepness * guess,
      -first_steepness * 0.5 * (mean(clouds.first) + mean(clouds.second));
  double damping = 1e-2;
  Regression<dim> now(clouds, phi);
  for (int k = 0; k < most_steps; ++k) {
    auto matrix = now.normal_matrix;
    matrix.diagonal().array() += damping * matrix.diagonal().maxCoeff();
    const Plane<dim> step = -matrix.ldlt().solve(now.gradient);
    const Regression<dim> next(clouds, phi + step);
    if (next.sum > now.sum) {
      damping *= 10;
      if (damping > 1e6) break;
      continue;
    }
    phi += step;
    now = next;
    damping = std::max(1e-12, damping / 10);
    if (step.norm() <= small_change * phi.norm()) break;
  }
  const double size = phi.template head<dim>().norm();
  return size > 0 ? Vector<dim>(phi.template head<dim>() / size) : guess;
}

template <int dim>
double margin(const TwoClouds<dim>& clouds, const Vector<dim>& n) {
  double highest = -std::numeric_limits<double>::infinity(), lowest = -highest;
  for (const Vector<dim>& x : clouds.first) highest = std::max(highest, n.dot(x));
  for (const Vector<dim>& x : clouds.second) lowest = std::min(lowest, n.dot(x));
  return lowest - highest;
}

// The soft end of a cloud: log sum exp(s k n . x) / (s k), with its mean place and spread.
template <int dim>
struct SoftEnd {
  double value = 0;
  Vector<dim> mean = Vector<dim>::Zero();
  Matrix<dim> spread = Matrix<dim>::Zero();

  // @param side  1: the highest points, -1: the lowest
  SoftEnd(std::span<const Vector<dim>> points, const Vector<dim>& n, double side, double k) {
    double end = -std::numeric_limits<double>::infinity(), sum = 0;
    for (const Vector<dim>& x : points) end = std::max(end, side * n.dot(x));
    for (const Vector<dim>& x : points) {
      const double exponent = k * (side * n.dot(x) - end);
      if (exponent < least_exponent) continue;
      const double weight = std::exp(exponent);
      sum += weight;
      mean += weight * x;
      spread += weight * x * x.transpose();
    }
    mean /= sum;
    spread = spread / sum - mean * mean.transpose();
    value = side * (end + std::log(sum) / k);
  }
};

template <int dim>
struct SoftMargin {
  SoftEnd<dim> first, second;
  SoftMargin(const TwoClouds<dim>& clouds, const Vector<dim>& n, double k)
      : first(clouds.first, n, 1, k), second(clouds.second, n, -1, k) {}
  double value() const { return second.value - first.value; }
  Vector<dim> path() const { return second.mean - first.mean; }
};

// Newton's method for the normal with the largest soft margin, on the unit sphere.
template <int dim>
Vector<dim> widest_margin(const TwoClouds<dim>& clouds, Vector<dim> n, double k) {
  SoftMargin<dim> now(clouds, n, k);
  for (int step = 0; step < most_steps; ++step) {
    const Eigen::Matrix<double, dim, dim - 1> T = frame_of<dim>(n).template rightCols<dim - 1>();
    const auto gradient = (T.transpose() * now.path()).eval();
    auto curvature = (k * T.transpose() * (now.first.spread + now.second.spread) * T).eval();
    curvature.diagonal().array() += std::max(1e-3, n.dot(now.path()));
    Vector<dim> move = T * curvature.ldlt().solve(gradient);
    if (move.norm() < small_turn) break;
    if (move.norm() > 0.3) move *= 0.3 / move.norm();
    bool better = false;
    for (int half = 0; half < most_halvings && !better; ++half, move /= 2) {
      const Vector<dim> trial = (n + move).normalized();
      const SoftMargin<dim> next(clouds, trial, k);
      if (next.value() <= now.value()) continue;
      better = true;
      n = trial;
      now = next;
    }
    if (!better) break;
  }
  return n;
}

}  // namespace

template <int dim>
PlaneNormal<dim> plane_between(const TwoClouds<dim>& clouds, const Vector<dim>& guess) {
  PlaneNormal<dim> result{.n = guess};
  if (!(margin(clouds, guess) > 0)) result.n = logistic_normal(clouds, guess);
  result.separates = margin(clouds, result.n) > 0;
  if (!result.separates) return result;
  for (const double k : steepness) result.n = widest_margin(clouds, result.n, k);
  result.separates = margin(clouds, result.n) > 0;
  return result;
}

template PlaneNormal<2> plane_between<2>(const TwoClouds<2>&, const Vector<2>&);
template PlaneNormal<3> plane_between<3>(const TwoClouds<3>&, const Vector<3>&);

}  // namespace gabion::mpm
