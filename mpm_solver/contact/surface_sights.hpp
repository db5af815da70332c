// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "mpm_solver/contact/surface_features.hpp"

/// Tests of simplices as seen from a point: the parts of find_features and features_in_front.
namespace gabion::mpm::sights {

// Two places whose distances from a point differ by less than this share are equally near.
inline constexpr double same_distance = 1e-9;

// Distance beyond the end of a simplex over which its depth fades out, as a share of the radius. At
// a bend by alpha its plane pushes (ShortestExit) up to R tan(alpha / 2) cos(alpha) there, which is
// largest at cos(alpha) = 0.618.
inline constexpr double fading_share = 0.301;

/// A simplex at the end of the step, with what a point sees of it.
template <int dim>
struct Sight {
  std::int32_t simplex = 0;
  ClosestPlace<dim> place;
  Vector<dim> normal = Vector<dim>::Zero();
  double height = 0;    // of the point above the plane
  double distance = 0;  // of the closest place
  bool crossed = false;
  bool was_behind = false;  // when the step began
  bool touched = false;
};

template <int dim>
bool has_vertex(const Simplex<dim>& simplex, std::int32_t vertex) {
  return std::find(simplex.begin(), simplex.end(), vertex) != simplex.end();
}

// Whether simplex b has all vertices of a that carry a's closest place.
template <int dim>
bool shares_place(const Simplex<dim>& a, const ClosestPlace<dim>& place, const Simplex<dim>& b) {
  for (int k = 0; k < dim; ++k) {
    if (place.weights[k] > 0 && !has_vertex<dim>(b, a[k])) return false;
  }
  return true;
}

// Whether the place is on the rim of the surface.
template <int dim>
bool is_on_rim(const FacingSurface<dim>& surface, const Simplex<dim>& simplex,
               const ClosestPlace<dim>& place) {
  if (surface.rim.empty()) return false;
  for (int k = 0; k < dim; ++k) {
    if (place.weights[k] > 0 && surface.rim[simplex[k]] == 0) return false;
  }
  return true;
}

// Whether a simplex comes to a place on a rim.
template <int dim>
bool meets(const FacingSurface<dim>& surface, const Vector<dim>& x, const Simplex<dim>& simplex) {
  const auto corners = corners_of<dim>(simplex, surface.end);
  return (closest_place<dim>(corners, x).x - x).norm() <= surface.seam;
}

/// The displacement path of a point in a step.
template <int dim>
struct Path {
  Vector<dim> from, to;
};

// Whether the displacement path of a point, relative to the simplex, goes through it.
// @param t  share of the path at which it meets the plane
template <int dim>
bool way_crosses(const std::array<Vector<dim>, dim>& start, const std::array<Vector<dim>, dim>& end,
                 const Path<dim>& path, double t) {
  std::array<Vector<dim>, dim> corners;
  for (int k = 0; k < dim; ++k) corners[k] = (1 - t) * start[k] + t * end[k];
  const Vector<dim> at = (1 - t) * path.from + t * path.to;
  double size = 0;
  for (int k = 1; k < dim; ++k) size = std::max(size, (corners[k] - corners[0]).norm());
  return (closest_place<dim>(corners, at).x - at).norm() <= 1e-6 * size;
}

// @param normal  of the simplex at the end of the step
template <int dim>
Sight<dim> sight_of(const FacingSurface<dim>& surface, const FacingSimplex& facing,
                    const Path<dim>& path, const Vector<dim>& normal) {
  const Simplex<dim>& simplex = surface.simplices[facing.simplex];
  const auto corners = corners_of<dim>(simplex, surface.end);
  Sight<dim> sight;
  sight.simplex = facing.simplex;
  sight.place = closest_place<dim>(corners, path.to);
  sight.normal = normal;
  sight.height = (path.to - corners[0]).dot(sight.normal);
  sight.distance = (path.to - sight.place.x).norm();
  sight.was_behind = facing.height <= 0;
  sight.touched = facing.touched;
  if (sight.height <= 0 && !sight.was_behind) {
    const double share = facing.height / (facing.height - sight.height);
    sight.crossed = way_crosses<dim>(corners_of<dim>(simplex, surface.start), corners, path, share);
  }
  return sight;
}

/// A simplex at the end of the step.
template <int dim>
struct Placed {
  std::int32_t simplex = 0;
  Vector<dim> normal = Vector<dim>::Zero();
};

// Whether each of two simplices has a part in front of the other one.
template <int dim>
bool reach_in_front(const FacingSurface<dim>& surface, const Placed<dim>& a, const Placed<dim>& b) {
  const auto reaches_in_front = [&](const Placed<dim>& other, const Placed<dim>& of) {
    const Vector<dim> origin = surface.end[surface.simplices[of.simplex][0]];
    const auto corners = corners_of<dim>(surface.simplices[other.simplex], surface.end);
    const double size = (corners[1] - corners[0]).norm();
    return std::any_of(corners.begin(), corners.end(), [&](const Vector<dim>& corner) {
      return (corner - origin).dot(of.normal) > 1e-6 * size;
    });
  };
  return reaches_in_front(a, b) && reaches_in_front(b, a);
}

// A place on an edge or corner is no minimum when a simplex that shares it has a nearer one.
template <int dim>
bool is_minimum(const FacingSurface<dim>& surface, const Sight<dim>& sight,
                const std::vector<Sight<dim>>& all) {
  const Simplex<dim>& own = surface.simplices[sight.simplex];
  const bool on_rim = is_on_rim<dim>(surface, own, sight.place);
  return std::none_of(all.begin(), all.end(), [&](const Sight<dim>& other) {
    if (other.distance >= (1 - same_distance) * sight.distance) return false;
    const Simplex<dim>& its = surface.simplices[other.simplex];
    return shares_place<dim>(own, sight.place, its) ||
           (on_rim && meets<dim>(surface, sight.place.x, its) &&
            !are_in_corner<dim>(surface, sight.simplex, other.simplex));
  });
}

// Whether a simplex, rather than another one, decides on which side of the surface the point is:
// the nearer one does; at a shared corner the one that has the point in front.
template <int dim>
bool tells_side(const Sight<dim>& a, const Sight<dim>& b) {
  if (a.distance < (1 - same_distance) * b.distance) return true;
  return a.distance <= (1 + same_distance) * b.distance && a.height > b.height;
}

template <int dim>
SurfaceFeature<dim> feature_of(const Sight<dim>& sight, const Vector<dim>& y) {
  SurfaceFeature<dim> feature{.simplex = sight.simplex,
                              .weights = sight.place.weights,
                              .x = sight.place.x,
                              .normal = sight.normal,
                              .distance = sight.height};
  if (sight.height > 0 && sight.place.num_corners() < dim) {
    feature.distance = sight.distance;
    feature.normal = (y - sight.place.x) / sight.distance;
  }
  return feature;
}

template <int dim>
bool is_new(const SurfaceFeature<dim>& feature, const std::vector<SurfaceFeature<dim>>& known,
            double size) {
  return std::none_of(known.begin(), known.end(), [&](const SurfaceFeature<dim>& other) {
    return (feature.x - other.x).norm() <= 1e-6 * size &&
           (feature.normal - other.normal).norm() <= 1e-6;
  });
}

// The nearest of the simplices in contact with the point at the end of the step before.
template <int dim>
const Sight<dim>* nearest_touched(const std::vector<Sight<dim>>& sights) {
  const Sight<dim>* best = nullptr;
  for (const Sight<dim>& sight : sights) {
    if (sight.touched && (!best || tells_side<dim>(sight, *best))) best = &sight;
  }
  return best;
}

template <int dim>
bool inside_corner(const FacingSurface<dim>& surface, const Sight<dim>& a, const Sight<dim>& b) {
  return reach_in_front<dim>(surface, {a.simplex, a.normal}, {b.simplex, b.normal});
}

template <int dim>
SurfaceFeature<dim> foot_of(const FacingSurface<dim>& surface, const Sight<dim>& sight,
                            const Vector<dim>& y) {
  const auto corners = corners_of<dim>(surface.simplices[sight.simplex], surface.end);
  return {.simplex = sight.simplex,
          .weights = weights_of_foot<dim>(corners, y),
          .x = y - sight.height * sight.normal,
          .normal = sight.normal,
          .distance = sight.height};
}

// Whether two simplices share the side of the first one that has no corner k.
template <int dim>
bool shares_side(const Simplex<dim>& own, int k, const Simplex<dim>& other) {
  for (int l = 0; l < dim; ++l) {
    if (has_vertex<dim>(other, own[l]) == (l == k)) return false;
  }
  return true;
}

// The place of the side without corner k that is closest to y, kept off its ends.
template <int dim>
ClosestPlace<dim> place_on_side(const std::array<Vector<dim>, dim>& corners, int k,
                                const Vector<dim>& y) {
  ClosestPlace<dim> place;
  const int a = (k + 1) % dim, b = (k + dim - 1) % dim;
  const Vector<dim> edge = corners[b] - corners[a];
  const double t =
      a == b ? 0 : std::clamp((y - corners[a]).dot(edge) / edge.squaredNorm(), 0.01, 0.99);
  place.weights[b] += t;
  place.weights[a] += 1 - t;
  place.x = corners[a] + t * edge;
  return place;
}

// The place of a simplex on its side without corner k, and whether that is on the rim.
template <int dim>
struct SimplexSide {
  int k = 0;
  Vector<dim> x = Vector<dim>::Zero();
  bool on_rim = false;
};

template <int dim>
SimplexSide<dim> side_of(const FacingSurface<dim>& surface, const Sight<dim>& sight, int k) {
  const Simplex<dim>& own = surface.simplices[sight.simplex];
  const auto place = place_on_side<dim>(corners_of<dim>(own, surface.end), k, sight.place.x);
  return {k, place.x, is_on_rim<dim>(surface, own, place)};
}

// Whether another simplex meets this one at a side.
template <int dim>
bool meets_at(const FacingSurface<dim>& surface, const Sight<dim>& sight,
              const SimplexSide<dim>& side, std::int32_t other) {
  const Simplex<dim>& its = surface.simplices[other];
  if (shares_side<dim>(surface.simplices[sight.simplex], side.k, its)) return true;
  return side.on_rim && other != sight.simplex && meets<dim>(surface, side.x, its) &&
         !are_in_corner<dim>(surface, sight.simplex, other);
}

}  // namespace gabion::mpm::sights
