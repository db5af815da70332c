// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/surface_features.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace gabion::mpm {

namespace {

// Two places whose distances from a point differ by less than this share are equally near.
constexpr double same_distance = 1e-9;

// Of the radius: how far beyond the end of a simplex. At a bend by alpha its plane pushes (WayOut)
// up to R tan(alpha / 2) cos(alpha) there, which is largest at cos(alpha) = 0.618.
constexpr double fading_share = 0.301;

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

/// A point that goes from x to y, and its heights above the plane of a simplex there.
template <int dim>
struct Way {
  Vector<dim> x, y;
  double start_height = 0, end_height = 0;
};

// Whether the way of a point, relative to the simplex, goes through it.
template <int dim>
bool way_crosses(const std::array<Vector<dim>, dim>& start, const std::array<Vector<dim>, dim>& end,
                 const Way<dim>& way) {
  const double t = way.start_height / (way.start_height - way.end_height);
  std::array<Vector<dim>, dim> corners;
  for (int k = 0; k < dim; ++k) corners[k] = (1 - t) * start[k] + t * end[k];
  const Vector<dim> at = (1 - t) * way.x + t * way.y;
  double size = 0;
  for (int k = 1; k < dim; ++k) size = std::max(size, (corners[k] - corners[0]).norm());
  return (closest_place<dim>(corners, at).x - at).norm() <= 1e-6 * size;
}

template <int dim>
Sight<dim> sight_of(const FacingSurface<dim>& surface, const FacingSimplex& facing,
                    const Vector<dim>& x, const Vector<dim>& y) {
  const Simplex<dim>& simplex = surface.simplices[facing.simplex];
  const auto corners = corners_of<dim>(simplex, surface.end);
  Sight<dim> sight;
  sight.simplex = facing.simplex;
  sight.place = closest_place<dim>(corners, y);
  sight.normal = simplex_normal<dim>(corners);
  sight.height = (y - corners[0]).dot(sight.normal);
  sight.distance = (y - sight.place.x).norm();
  sight.was_behind = facing.height <= 0;
  sight.touched = facing.touched;
  if (sight.height <= 0 && !sight.was_behind) {
    const Way<dim> way{.x = x, .y = y, .start_height = facing.height, .end_height = sight.height};
    sight.crossed = way_crosses<dim>(corners_of<dim>(simplex, surface.start), corners, way);
  }
  return sight;
}

// A place on an edge or corner is no minimum when a simplex that shares it has a nearer one.
template <int dim>
bool is_minimum(const FacingSurface<dim>& surface, const Sight<dim>& sight,
                const std::vector<Sight<dim>>& all) {
  const Simplex<dim>& own = surface.simplices[sight.simplex];
  return std::none_of(all.begin(), all.end(), [&](const Sight<dim>& other) {
    return other.distance < (1 - same_distance) * sight.distance &&
           shares_place<dim>(own, sight.place, surface.simplices[other.simplex]);
  });
}

// Whether a simplex tells better than another one on which side of the surface the point is: the
// nearer one does; at a corner that they share, the one that has the point in front.
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

}  // namespace

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

namespace {

// Of the foot of y on the line or plane of a simplex; < 0 beyond its sides.
std::array<double, 2> weights_of_foot(const std::array<Vector<2>, 2>& c, const Vector<2>& y) {
  const Vector<2> edge = c[1] - c[0];
  const double t = (y - c[0]).dot(edge) / edge.squaredNorm();
  return {1 - t, t};
}

std::array<double, 3> weights_of_foot(const std::array<Vector<3>, 3>& c, const Vector<3>& y) {
  const Vector<3> normal = (c[1] - c[0]).cross(c[2] - c[0]);
  const auto share = [&](int i, int j) {
    return normal.dot((c[i] - y).cross(c[j] - y)) / normal.squaredNorm();
  };
  return {share(1, 2), share(2, 0), share(0, 1)};
}

std::array<double, 2> weights_on_segment(const std::array<Vector<2>, 2>& c, const Vector<2>& y) {
  const double t = std::clamp(weights_of_foot(c, y)[1], 0.0, 1.0);
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
  return weights_of_foot(c, y);
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

namespace {

// The nearest one of the simplices that the point touched when the step before ended.
template <int dim>
const Sight<dim>* nearest_touched(const std::vector<Sight<dim>>& sights) {
  const Sight<dim>* best = nullptr;
  for (const Sight<dim>& sight : sights) {
    if (sight.touched && (!best || tells_side<dim>(sight, *best))) best = &sight;
  }
  return best;
}

// Whether the point is behind a simplex: its way led through, or it was and has not come back.
template <int dim>
bool is_under(const Sight<dim>& sight, const Sight<dim>* touched) {
  if (sight.height > 0) return false;
  const bool above_inside = sight.place.num_corners() == dim;
  if (!sight.was_behind) return sight.crossed || above_inside;
  if (touched->height > 0 || !touched->was_behind) return false;
  return above_inside || sight.distance <= (1 + same_distance) * touched->distance;
}

// Whether each of two simplices has a part in front of the other one.
template <int dim>
bool inside_corner(const FacingSurface<dim>& surface, const Sight<dim>& a, const Sight<dim>& b) {
  const auto reaches_in_front = [&](const Sight<dim>& other, const Sight<dim>& of) {
    const Vector<dim> origin = surface.end[surface.simplices[of.simplex][0]];
    const auto corners = corners_of<dim>(surface.simplices[other.simplex], surface.end);
    const double size = (corners[1] - corners[0]).norm();
    return std::any_of(corners.begin(), corners.end(), [&](const Vector<dim>& corner) {
      return (corner - origin).dot(of.normal) > 1e-6 * size;
    });
  };
  return reaches_in_front(a, b) && reaches_in_front(b, a);
}

template <int dim>
SurfaceFeature<dim> foot_of(const FacingSurface<dim>& surface, const Sight<dim>& sight,
                            const Vector<dim>& y) {
  const auto corners = corners_of<dim>(surface.simplices[sight.simplex], surface.end);
  return {.simplex = sight.simplex,
          .weights = weights_of_foot(corners, y),
          .x = y - sight.height * sight.normal,
          .normal = sight.normal,
          .distance = sight.height};
}

// Beyond the end of its simplex a foot is on the simplex that is next to it there: the force goes
// to the vertices around it.
template <int dim>
void move_to_nearest(const FacingSurface<dim>& surface, const std::vector<Sight<dim>>& all,
                     SurfaceFeature<dim>& foot) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Sight<dim>& sight : all) {
    const auto corners = corners_of<dim>(surface.simplices[sight.simplex], surface.end);
    const auto place = closest_place<dim>(corners, foot.x);
    const double distance = (place.x - foot.x).squaredNorm();
    if (distance >= nearest) continue;
    nearest = distance;
    foot.simplex = sight.simplex;
    foot.weights = place.weights;
  }
}

// Whether another simplex meets this one in an inside corner at the side that has no corner k.
template <int dim>
bool bends_inwards(const FacingSurface<dim>& surface, const Sight<dim>& sight, int k,
                   const std::vector<Sight<dim>>& all) {
  const Simplex<dim>& own = surface.simplices[sight.simplex];
  return std::any_of(all.begin(), all.end(), [&](const Sight<dim>& other) {
    const Simplex<dim>& its = surface.simplices[other.simplex];
    for (int l = 0; l < dim; ++l) {
      if (has_vertex<dim>(its, own[l]) == (l == k)) return false;
    }
    return inside_corner<dim>(surface, sight, other);
  });
}

// At an inside corner the depth below a plane fades out beyond the end of its simplex. Whether a
// simplex, whose place is no minimum, still counts so.
template <int dim>
bool fades_out(const FacingSurface<dim>& surface, const Sight<dim>& sight,
               const SurfaceFeature<dim>& foot, const std::vector<Sight<dim>>& all, double margin) {
  if ((foot.x - sight.place.x).norm() > margin) return false;
  for (int k = 0; k < dim; ++k) {
    if (foot.weights[k] < 0 && !bends_inwards<dim>(surface, sight, k, all)) return false;
  }
  return true;
}

// Simplices that were farther from the point cannot count: not within reach, not crossed, and no
// neighbour of one that counts. A way longer than the reach may lead round a corner behind one.
template <int dim>
double farthest_that_counts(const FacingSurface<dim>& surface, const Vector<dim>& x,
                            const Vector<dim>& y, double reach) {
  const double way = (y - x).norm() + surface.motion;
  if (way > reach) return std::numeric_limits<double>::infinity();
  return reach + surface.size + way;
}

}  // namespace

template <int dim>
void find_features(const FacingSurface<dim>& surface, const Vector<dim>& x, const Vector<dim>& y,
                   const FeatureReach& reach, std::vector<SurfaceFeature<dim>>& features) {
  features.clear();
  const double fading = fading_share * reach.radius;
  thread_local std::vector<Sight<dim>> sights;
  sights.clear();
  const double farthest = farthest_that_counts<dim>(surface, x, y, reach.distance + fading);
  for (const FacingSimplex& facing : surface.facing) {
    if (facing.distance > farthest) continue;
    sights.push_back(sight_of<dim>(surface, facing, x, y));
  }
  const Sight<dim>* touched = nearest_touched<dim>(sights);
  const Sight<dim>* behind = nullptr;  // the least deep
  for (const Sight<dim>& sight : sights) {
    if (!is_under<dim>(sight, touched)) continue;
    if (!behind || sight.height > behind->height) behind = &sight;
  }
  if (behind) features.push_back(feature_of<dim>(*behind, y));
  for (const Sight<dim>& sight : sights) {
    if (&sight == behind) continue;
    const bool over = sight.height > 0 && sight.distance < reach.distance;
    const bool counts =
        over ? is_minimum<dim>(surface, sight, sights) : is_under<dim>(sight, touched);
    if (!counts && !over && !behind) continue;
    if (behind && !inside_corner<dim>(surface, *behind, sight)) continue;
    if (!counts) {
      auto foot = foot_of<dim>(surface, sight, y);
      if (fades_out<dim>(surface, sight, foot, sights, fading)) {
        move_to_nearest<dim>(surface, sights, foot);
        features.push_back(foot);
      }
      continue;
    }
    const auto feature = feature_of<dim>(sight, y);
    if (is_new<dim>(feature, features, reach.distance)) features.push_back(feature);
  }
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
template void find_features<2>(const FacingSurface<2>&, const Vector<2>&, const Vector<2>&,
                               const FeatureReach&, std::vector<SurfaceFeature<2>>&);
template void find_features<3>(const FacingSurface<3>&, const Vector<3>&, const Vector<3>&,
                               const FeatureReach&, std::vector<SurfaceFeature<3>>&);

}  // namespace gabion::mpm
