// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/surface_features.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mpm_solver/contact/surface_sights.hpp"

namespace gabion::mpm {

using namespace sights;

template <int dim>
bool are_in_corner(const FacingSurface<dim>& surface, std::int32_t a, std::int32_t b) {
  if (surface.owner.empty() || surface.owner[a] == surface.owner[b]) return false;
  const auto placed = [&](std::int32_t s) {
    const auto corners = corners_of<dim>(surface.simplices[s], surface.end);
    return Placed<dim>{s, simplex_normal<dim>(corners)};
  };
  const auto first = placed(a), second = placed(b);
  return first.normal.dot(second.normal) < corner_cosine &&
         reach_in_front<dim>(surface, first, second);
}

namespace {

// Whether the point is behind a simplex: its displacement path led through it, or it was behind it
// before and has not come back.
template <int dim>
bool is_under(const Sight<dim>& sight, const Sight<dim>* touched) {
  if (sight.height > 0) return false;
  const bool above_inside = sight.place.num_corners() == dim;
  if (!sight.was_behind) return sight.crossed || above_inside;
  if (touched->height > 0 || !touched->was_behind) return false;
  return above_inside || sight.distance <= (1 + same_distance) * touched->distance;
}

// A foot beyond the end of its simplex lies on the next simplex, whose vertices get the force.
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

// Whether another simplex meets this one in a re-entrant corner at the side that has no corner k.
template <int dim>
bool bends_inwards(const FacingSurface<dim>& surface, const Sight<dim>& sight, int k,
                   const std::vector<Sight<dim>>& all) {
  const SimplexSide<dim> side = side_of<dim>(surface, sight, k);
  return std::any_of(all.begin(), all.end(), [&](const Sight<dim>& other) {
    return meets_at<dim>(surface, sight, side, other.simplex) &&
           inside_corner<dim>(surface, sight, other);
  });
}

// Whether a simplex whose closest place is no minimum still counts: at a re-entrant corner the
// depth below a plane fades out beyond the end of its simplex.
template <int dim>
bool fades_out(const FacingSurface<dim>& surface, const Sight<dim>& sight,
               const SurfaceFeature<dim>& foot, const std::vector<Sight<dim>>& all, double margin) {
  if ((foot.x - sight.place.x).norm() > margin) return false;
  for (int k = 0; k < dim; ++k) {
    if (foot.weights[k] < 0 && !bends_inwards<dim>(surface, sight, k, all)) return false;
  }
  return true;
}

// Distance at the start of the step beyond which simplices cannot count: they are not within reach,
// not crossed, and no neighbours of one that counts. A path longer than the reach may lead round a
// corner behind a simplex.
template <int dim>
double farthest_that_counts(const FacingSurface<dim>& surface, const Vector<dim>& x,
                            const Vector<dim>& y, double reach) {
  const double path = (y - x).norm() + surface.motion;
  if (path > reach) return std::numeric_limits<double>::infinity();
  return reach + surface.size + path;
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
    const auto corners = corners_of<dim>(surface.simplices[facing.simplex], surface.end);
    sights.push_back(sight_of<dim>(surface, facing, Path<dim>{x, y}, simplex_normal<dim>(corners)));
  }
  const Sight<dim>* touched = nearest_touched<dim>(sights);
  const Sight<dim>* behind = nullptr;  // the one with the smallest penetration
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

template bool are_in_corner<2>(const FacingSurface<2>&, std::int32_t, std::int32_t);
template bool are_in_corner<3>(const FacingSurface<3>&, std::int32_t, std::int32_t);
template void find_features<2>(const FacingSurface<2>&, const Vector<2>&, const Vector<2>&,
                               const FeatureReach&, std::vector<SurfaceFeature<2>>&);
template void find_features<3>(const FacingSurface<3>&, const Vector<3>&, const Vector<3>&,
                               const FeatureReach&, std::vector<SurfaceFeature<3>>&);

}  // namespace gabion::mpm
