// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/moving_surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include "common/mechanics/elements/shape_functions.hpp"

namespace gabion::mpm {

std::vector<FacetPoint> facet_points(CellType type, int n) {
  std::vector<FacetPoint> result;
  if (type == CellType::line2) {
    for (int k = 0; k < n; ++k) {
      const double s = (k + 0.5) / n;
      result.push_back({.phi = {1 - s, s, 0, 0}, .share = 1.0 / n});
    }
    return result;
  }
  double total = 0;
  ShapeValues<2> shape;
  for (const auto& q : point_rule<2>(type, n)) {
    shape_functions<2>(type, q.xi, shape);
    FacetPoint point{.share = q.weight};
    std::copy_n(shape.N, num_nodes(type), point.phi.begin());
    total += q.weight;
    result.push_back(point);
  }
  for (auto& point : result) point.share /= total;
  return result;
}

template <int dim>
MovingSurface<dim>::MovingSurface(ContactSurface<dim> surface)
    : surface_(std::move(surface)),
      vertices_per_facet_(num_nodes(surface_.facet_type)),
      vertices_(surface_.vertices) {}

template <int dim>
void MovingSurface<dim>::set_displacement(std::span<const double> displacement) {
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    vertices_[i] =
        surface_.vertices[i] + Eigen::Map<const Vector<dim>>(displacement.data() + i * dim);
  }
}

template <int dim>
Vector<dim> MovingSurface<dim>::position(std::int32_t facet,
                                         const std::array<double, 4>& phi) const {
  Vector<dim> x = Vector<dim>::Zero();
  for (int k = 0; k < vertices_per_facet_; ++k) x += phi[k] * vertices_[vertex(facet, k)];
  return x;
}

template <int dim>
Matrix<dim> MovingSurface<dim>::frame(std::int32_t facet, const Vector<dim>& n) const {
  Matrix<dim> result;
  result.col(0) = n;
  if constexpr (dim == 2) {
    result.col(1) = Vector<2>(-n[1], n[0]);
  } else {
    const Vector<3> along = vertices_[vertex(facet, 1)] - vertices_[vertex(facet, 0)];
    result.col(1) = (along - along.dot(n) * n).normalized();
    result.col(2) = n.cross(result.col(1));
  }
  return result;
}

template class MovingSurface<2>;
template class MovingSurface<3>;

}  // namespace gabion::mpm
