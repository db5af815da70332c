// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Geometry>
#include <algorithm>

#include "mpm_solver/contact/surface_features.hpp"

namespace gabion::mpm {

template <int dim>
Vector<dim> simplex_normal(const std::array<Vector<dim>, dim>& corners) {
  const Vector<dim> edge = corners[1] - corners[0];
  if constexpr (dim == 2) {
    return Vector<2>(edge[1], -edge[0]).normalized();
  } else {
    return edge.cross(corners[2] - corners[0]).normalized();
  }
}

template <int dim>
std::vector<SimplexBounds<dim>> bounds_of(std::span<const Simplex<dim>> simplices,
                                          std::span<const Vector<dim>> vertices) {
  std::vector<SimplexBounds<dim>> result;
  result.reserve(simplices.size());
  for (const Simplex<dim>& simplex : simplices) {
    const auto corners = corners_of<dim>(simplex, vertices);
    SimplexBounds<dim>& bounds = result.emplace_back();
    bounds.normal = simplex_normal<dim>(corners);
    bounds.centre.setZero();
    for (const Vector<dim>& corner : corners) bounds.centre += corner / dim;
    for (const Vector<dim>& corner : corners) {
      bounds.radius = std::max(bounds.radius, (corner - bounds.centre).norm());
    }
  }
  return result;
}

template <int dim>
int ClosestPlace<dim>::num_corners() const {
  return static_cast<int>(
      std::count_if(weights.begin(), weights.end(), [](double w) { return w > 0; }));
}

template <>
std::array<double, 2> weights_of_foot<2>(const std::array<Vector<2>, 2>& c, const Vector<2>& y) {
  const Vector<2> edge = c[1] - c[0];
  const double t = (y - c[0]).dot(edge) / edge.squaredNorm();
  return {1 - t, t};
}

template <>
std::array<double, 3> weights_of_foot<3>(const std::array<Vector<3>, 3>& c, const Vector<3>& y) {
  const Vector<3> normal = (c[1] - c[0]).cross(c[2] - c[0]);
  const auto share = [&](int i, int j) {
    return normal.dot((c[i] - y).cross(c[j] - y)) / normal.squaredNorm();
  };
  return {share(1, 2), share(2, 0), share(0, 1)};
}

namespace {

std::array<double, 2> weights_on_segment(const std::array<Vector<2>, 2>& c, const Vector<2>& y) {
  const double t = std::clamp(weights_of_foot<2>(c, y)[1], 0.0, 1.0);
  return {1 - t, t};
}

// Voronoi regions of a triangle: corners, edges, inside.
std::array<double, 3> weights_on_triangle(const std::array<Vector<3>, 3>& c, const Vector<3>& y) {
  const Vector<3> ab = c[1] - c[0], ac = c[2] - c[0];
  const double d1 = ab.dot(y - c[0]), d2 = ac.dot(y - c[0]);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  const double d3 = ab.dot(y - c[1]), d4 = ac.dot(y - c[1]);
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  const double d5 = ab.dot(y - c[2]), d6 = ac.dot(y - c[2]);
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  const double at_c = d1 * d4 - d3 * d2, at_b = d5 * d2 - d1 * d6, at_a = d3 * d6 - d5 * d4;
  if (at_c <= 0 && d1 >= 0 && d3 <= 0) {
    const double t = d1 / (d1 - d3);
    return {1 - t, t, 0};
  }
  if (at_b <= 0 && d2 >= 0 && d6 <= 0) {
    const double t = d2 / (d2 - d6);
    return {1 - t, 0, t};
  }
  if (at_a <= 0 && d4 >= d3 && d5 >= d6) {
    const double t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0, 1 - t, t};
  }
  return weights_of_foot<3>(c, y);
}

}  // namespace

template <int dim>
ClosestPlace<dim> closest_place(const std::array<Vector<dim>, dim>& corners, const Vector<dim>& y) {
  ClosestPlace<dim> place;
  if constexpr (dim == 2) {
    place.weights = weights_on_segment(corners, y);
  } else {
    place.weights = weights_on_triangle(corners, y);
  }
  for (int k = 0; k < dim; ++k) place.x += place.weights[k] * corners[k];
  return place;
}

template std::vector<SimplexBounds<2>> bounds_of<2>(std::span<const Simplex<2>>,
                                                    std::span<const Vector<2>>);
template std::vector<SimplexBounds<3>> bounds_of<3>(std::span<const Simplex<3>>,
                                                    std::span<const Vector<3>>);
template Vector<2> simplex_normal<2>(const std::array<Vector<2>, 2>&);
template Vector<3> simplex_normal<3>(const std::array<Vector<3>, 3>&);
template struct ClosestPlace<2>;
template struct ClosestPlace<3>;
template ClosestPlace<2> closest_place<2>(const std::array<Vector<2>, 2>&, const Vector<2>&);
template ClosestPlace<3> closest_place<3>(const std::array<Vector<3>, 3>&, const Vector<3>&);

}  // namespace gabion::mpm
