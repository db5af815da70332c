// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/sided_surface.hpp"

#include <algorithm>
#include <utility>

namespace gabion::mpm {

template <int dim>
SidedSurface<dim>::SidedSurface(const ContactSurface<dim>& surface,
                                std::vector<Vector<dim>> vertices, double reach)
    : vertices_(std::move(vertices)),
      simplices_(simplices(surface)),
      bounds_(bounds_of<dim>(simplices_, vertices_)),
      rim_(rim_vertices<dim>(simplices_, vertices_.size())),
      hash_(simplices_, vertices_, reach) {}

template <int dim>
SurfaceSide SidedSurface<dim>::side(const Vector<dim>& x, double within) const {
  SurfaceSide nearest;
  for (const std::int32_t s : hash_.near(x)) {
    const double farthest = (1 + 2 * same_distance) * std::min(within, nearest.distance);
    if (bounds_[s].is_beyond(x, farthest)) continue;
    const SurfaceSide side = side_of(s, x);
    const double margin = same_distance * side.distance;
    const bool nearer = side.distance < nearest.distance - margin;
    const bool equal = std::abs(side.distance - nearest.distance) <= margin;
    if (nearer || (equal && std::abs(side.height) > std::abs(nearest.height))) nearest = side;
  }
  return nearest;
}

template <int dim>
SurfaceSide SidedSurface<dim>::side_of(std::int32_t s, const Vector<dim>& x) const {
  const Simplex<dim>& simplex = simplices_[s];
  const auto corners = corners_of<dim>(simplex, vertices_);
  const auto place = closest_place<dim>(corners, x);
  SurfaceSide side;
  side.distance = (x - place.x).norm();
  side.height = (x - corners[0]).dot(bounds_[s].normal);
  const bool aside = std::abs(side.height) < (1 - 1e-6) * side.distance;
  side.beyond_rim = aside && place.num_corners() < dim;
  for (int k = 0; k < dim; ++k) {
    if (place.weights[k] > 0) side.beyond_rim &= rim_[simplex[k]] != 0;
  }
  return side;
}

template <int dim>
StartSphere<dim> start_sphere(const MaterialPoints<dim>& points, std::int32_t p) {
  return {points.x[p], points.depth[p], cube_side<dim>(points.V0[p])};
}

template <int dim>
std::optional<double> depth_inside(const StartSphere<dim>& sphere, const SurfaceSide& side,
                                   bool measured) {
  if (!side.in_front()) return sphere.radius + side.distance;
  const double depth = sphere.radius - side.distance;
  if (!measured || depth <= allowed_overlap * sphere.radius) return std::nullopt;
  return depth;
}

template class SidedSurface<2>;
template class SidedSurface<3>;
template StartSphere<2> start_sphere<2>(const MaterialPoints<2>&, std::int32_t);
template StartSphere<3> start_sphere<3>(const MaterialPoints<3>&, std::int32_t);
template std::optional<double> depth_inside<2>(const StartSphere<2>&, const SurfaceSide&, bool);
template std::optional<double> depth_inside<3>(const StartSphere<3>&, const SurfaceSide&, bool);

}  // namespace gabion::mpm
