// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/beams/fibres.hpp"

#include <cmath>
#include <numbers>

namespace gabion::fem {

namespace {

constexpr int layers_in_the_plane = 20, layers_in_space = 6;  // even: none lies across an axis
constexpr int rings_of_solid = 6, sectors = 48;               // a multiple of 4, likewise

struct Point {
  double x = 0, weight = 0;
};

/// Two points of Gauss in each of n equal parts of [low, high].
std::vector<Point> points_between(double low, double high, int n) {
  std::vector<Point> points;
  const double part = (high - low) / n, off = 0.5 * part / std::numbers::sqrt3;
  for (int k = 0; k < n; ++k) {
    const double middle = low + (k + 0.5) * part;
    points.push_back({middle - off, 0.5 * part});
    points.push_back({middle + off, 0.5 * part});
  }
  return points;
}

}  // namespace

std::vector<Fibre> rectangle_fibres(double height, double width, int dim) {
  const auto across = [](double size, int n) { return points_between(-size / 2, size / 2, n); };
  const auto ys = across(height, dim == 2 ? layers_in_the_plane : layers_in_space);
  const auto zs = dim == 2 ? std::vector<Point>{{0, width}} : across(width, layers_in_space);
  std::vector<Fibre> fibres;
  for (const Point& y : ys) {
    for (const Point& z : zs) fibres.push_back({y.x, z.x, y.weight * z.weight});
  }
  return fibres;
}

std::vector<Fibre> ring_fibres(double diameter, double inner) {
  // The points are spaced evenly over the square of the radius: dA = d(r^2) / 2 d(angle).
  const auto squares =
      points_between(inner * inner / 4, diameter * diameter / 4, inner > 0 ? 1 : rings_of_solid);
  constexpr double sector = 2 * std::numbers::pi / sectors;
  std::vector<Fibre> fibres;
  for (const Point& square : squares) {
    const double r = std::sqrt(square.x);
    for (int k = 0; k < sectors; ++k) {
      const double angle = (k + 0.5) * sector;
      fibres.push_back({r * std::cos(angle), r * std::sin(angle), 0.5 * square.weight * sector});
    }
  }
  return fibres;
}

}  // namespace gabion::fem
