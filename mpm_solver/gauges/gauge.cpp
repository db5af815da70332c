// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/gauges/gauge.hpp"

#include <Eigen/Geometry>
#include <utility>

#include "common/base/require.hpp"

namespace gabion::mpm {

namespace {

// Area of corners in one line, over the square of their distances.
constexpr double flat_area = 1e-9;

constexpr const char* in_line = "found corners in one line, allowed: corners of a piece of a plane";

}  // namespace

template <int dim>
Gauge<dim>::Gauge(std::string name_, const Corners& corners)
    : name(std::move(name_)), foot(corners.front()), forward(Vector<dim>::Zero()) {
  const Vector<dim> way_up = corners.back() - foot;
  height = way_up.norm();
  if constexpr (dim == 2) {
    require<ConfigError>(height > 0, in_line);
    size = height;
    normal = Vector<2>(way_up[1], -way_up[0]) / height;
    up = way_up / (height * height);
  } else {
    const Vector<3> line = corners[1] - foot;
    const Vector<3> product = line.cross(way_up);
    size = product.norm();
    require<ConfigError>(size > flat_area * (line.squaredNorm() + way_up.squaredNorm()), in_line);
    normal = product / size;
    up = normal.cross(line) / size;
    forward = way_up.cross(normal) / size;
  }
}

template <int dim>
bool Gauge<dim>::holds(const Vector<dim>& x) const {
  const double high = up.dot(x - foot), far = forward.dot(x - foot);
  return high >= 0 && high < 1 && far >= 0 && far < 1;
}

template <int dim>
int Gauge<dim>::crossing(const Vector<dim>& x0, const Vector<dim>& x1) const {
  const double before = distance(x0), after = distance(x1);
  if ((before < 0) == (after < 0)) return 0;
  if (!holds(x0 + before / (before - after) * (x1 - x0))) return 0;
  return after < 0 ? -1 : 1;
}

template struct Gauge<2>;
template struct Gauge<3>;

}  // namespace gabion::mpm
