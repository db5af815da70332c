// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/seams.hpp"

#include <algorithm>
#include <map>

#include "common/mechanics/mesh/disjoint_sets.hpp"
#include "mpm_solver/contact/facet_hash.hpp"

namespace gabion::mpm {

namespace {

/// A place on the rim of a surface, off the ends of the side of the simplex that it lies on.
template <int dim>
struct RimPlace {
  std::int32_t simplex = 0;
  Vector<dim> x = Vector<dim>::Zero();
};

// Shares of an edge of this length: its middle, and what is near its ends but not at them.
std::vector<double> shares_of_edge(double length, double tolerance) {
  const double end = std::max(0.02, 2 * tolerance / length);
  if (end >= 0.5) return {0.5};
  return {end, 0.5, 1 - end};
}

template <int dim>
std::vector<RimPlace<dim>> rim_places(const PlacedSurface<dim>& surface, double tolerance) {
  using Side = std::array<std::int32_t, dim - 1>;
  std::map<Side, std::vector<std::int32_t>> simplices_at;
  for (std::size_t s = 0; s < surface.simplices.size(); ++s) {
    for (int k = 0; k < dim; ++k) {
      Side side;
      for (int l = 0; l < dim - 1; ++l) side[l] = surface.simplices[s][(k + l) % dim];
      std::sort(side.begin(), side.end());
      simplices_at[side].push_back(static_cast<std::int32_t>(s));
    }
  }
  std::vector<RimPlace<dim>> places;
  for (const auto& [side, simplices] : simplices_at) {
    if (simplices.size() > 1) continue;
    const Vector<dim>& a = surface.vertices[side.front()];
    const Vector<dim> edge = surface.vertices[side.back()] - a;
    if constexpr (dim == 2) {
      places.push_back({simplices[0], a});
    } else {
      for (const double t : shares_of_edge(edge.norm(), tolerance)) {
        places.push_back({simplices[0], a + t * edge});
      }
    }
  }
  return places;
}

template <int dim>
using Corners = std::array<Vector<dim>, dim>;

template <int dim>
bool reaches_in_front(const Corners<dim>& corners, const Corners<dim>& of, double tolerance) {
  const Vector<dim> normal = simplex_normal<dim>(of);
  return std::any_of(corners.begin(), corners.end(), [&](const Vector<dim>& corner) {
    return (corner - of[0]).dot(normal) > tolerance;
  });
}

// Whether two simplices that meet are one surface.
template <int dim>
bool are_one(const Corners<dim>& a, const Corners<dim>& b, double tolerance) {
  if (simplex_normal<dim>(a).dot(simplex_normal<dim>(b)) >= corner_cosine) return true;
  return !reaches_in_front<dim>(a, b, tolerance) && !reaches_in_front<dim>(b, a, tolerance);
}

/// Whether the rim of one surface meets another one so that both are one surface.
template <int dim>
bool rim_joins(const std::vector<RimPlace<dim>>& rim, const PlacedSurface<dim>& own,
               const PlacedSurface<dim>& other, double tolerance) {
  std::vector<Vector<dim>> places;
  for (const auto& place : rim) places.push_back(place.x);
  const FacetHash<dim> hash(other.simplices, other.vertices, tolerance, places);
  return std::any_of(rim.begin(), rim.end(), [&](const RimPlace<dim>& place) {
    const auto corners = corners_of<dim>(own.simplices[place.simplex], own.vertices);
    const auto near = hash.near(place.x);
    return std::any_of(near.begin(), near.end(), [&](std::int32_t s) {
      const auto its = corners_of<dim>(other.simplices[s], other.vertices);
      return (closest_place<dim>(its, place.x).x - place.x).norm() <= tolerance &&
             are_one<dim>(corners, its, tolerance);
    });
  });
}

}  // namespace

template <int dim>
std::vector<std::int32_t> joint_surfaces(const std::vector<PlacedSurface<dim>>& surfaces,
                                         double tolerance) {
  const auto count = static_cast<std::int32_t>(surfaces.size());
  DisjointSets sets(surfaces.size());
  std::vector<std::vector<RimPlace<dim>>> rims;
  if (count > 1) {
    for (const auto& surface : surfaces) rims.push_back(rim_places<dim>(surface, tolerance));
  }
  for (std::int32_t a = 0; a < count; ++a) {
    for (std::int32_t b = 0; b < count; ++b) {
      if (sets.find(a) == sets.find(b)) continue;
      if (rim_joins<dim>(rims[a], surfaces[a], surfaces[b], tolerance)) sets.join(a, b);
    }
  }
  std::vector<std::int32_t> first;
  for (std::int32_t a = 0; a < count; ++a) first.push_back(sets.find(a));
  return first;
}

template std::vector<std::int32_t> joint_surfaces<2>(const std::vector<PlacedSurface<2>>&, double);
template std::vector<std::int32_t> joint_surfaces<3>(const std::vector<PlacedSurface<3>>&, double);

}  // namespace gabion::mpm
