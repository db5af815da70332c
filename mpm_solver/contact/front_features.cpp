// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/front_features.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mpm_solver/contact/surface_sights.hpp"

namespace gabion::mpm {

using namespace sights;

namespace {

// Distances within this share of a limit may be on either side of it by rounding.
constexpr double rounding = 1e-6;

template <int dim>
std::int32_t owner_of(const FacingSurface<dim>& surface, std::int32_t simplex) {
  return surface.owner.empty() ? 0 : surface.owner[simplex];
}

/// The simplices of a view, each looked at where it is needed.
template <int dim>
class Front {
 public:
  Front(const FrontView<dim>& view, const Path<dim>& path) : view_(view), path_(path) {}

  // Whether a simplex of the list surely is farther from the end of the displacement path.
  bool is_beyond(const FacingSimplex& facing, double distance) const {
    return facing.distance - view_.nearer > (1 + rounding) * distance ||
           is_beyond(facing.simplex, path_.to, distance);
  }

  const FacingSurface<dim>& surface() const { return view_.surface; }

  // Whether at the end of the step a simplex surely is farther from a place.
  bool is_beyond(std::int32_t s, const Vector<dim>& place, double distance) const {
    return view_.bounds[s].is_beyond(place, distance + motion_of(s));
  }

  // Position of the point before a simplex as the step began. @returns false: it does not face it
  bool faces(std::int32_t s, FacingSimplex& facing) const {
    const SimplexBounds<dim>& bounds = view_.bounds[s];
    const Vector<dim>& corner = surface().start[surface().simplices[s][0]];
    facing.simplex = s;
    facing.height = (path_.from - corner).dot(bounds.normal);
    facing.touched = touched(s);
    if (facing.height <= 0 && !facing.touched) return false;
    return !bounds.is_beyond(path_.from, view_.margin);
  }

  Vector<dim> normal(std::int32_t s) const {
    if (rests(s)) return view_.bounds[s].normal;
    return simplex_normal<dim>(corners_of<dim>(surface().simplices[s], surface().end));
  }

  std::int32_t neighbour(std::int32_t s, int k) const { return view_.neighbours[s][k]; }
  const Path<dim>& path() const { return path_; }

 private:
  bool rests(std::int32_t s) const {
    return surface().motion == 0 || view_.at_rest[owner_of(surface(), s)] != 0;
  }
  double motion_of(std::int32_t s) const { return rests(s) ? 0 : surface().motion; }

  bool touched(std::int32_t s) const {
    const std::int32_t owner = owner_of(surface(), s);
    return std::any_of(view_.touched.begin(), view_.touched.end(), [&](const auto& touch) {
      return touch.owner == owner && touch.normal.dot(view_.bounds[s].normal) > same_normal;
    });
  }

  const FrontView<dim>& view_;
  const Path<dim>& path_;
};

enum class Answer { no, yes, unknown };

// See find_features: whether a simplex meets another one in a re-entrant corner at its side without
// corner k. @param farthest  all simplices that are nearer to `y` are known [m]
template <int dim>
Answer bends_inwards(const Front<dim>& front, const Sight<dim>& sight, int k, double farthest) {
  const FacingSurface<dim>& surface = front.surface();
  FacingSimplex facing;
  const auto bends = [&](std::int32_t s) {
    return front.faces(s, facing) &&
           reach_in_front<dim>(surface, {sight.simplex, sight.normal}, {s, front.normal(s)});
  };
  const std::int32_t next = front.neighbour(sight.simplex, k);
  if (next == several_neighbours) return Answer::unknown;
  if (next != no_neighbour && bends(next)) return Answer::yes;
  const SimplexSide<dim> side = side_of<dim>(surface, sight, k);
  if (!side.on_rim) return Answer::no;
  if ((front.path().to - side.x).norm() + surface.seam > farthest) return Answer::unknown;
  const bool found = std::ranges::any_of(surface.facing, [&](const FacingSimplex& other) {
    const std::int32_t s = other.simplex;
    return !front.is_beyond(s, side.x, surface.seam) && meets_at<dim>(surface, sight, side, s) &&
           bends(s);
  });
  return found ? Answer::yes : Answer::no;
}

template <int dim>
Answer fades_out(const Front<dim>& front, const Sight<dim>& sight, const SurfaceFeature<dim>& foot,
                 const FeatureReach& reach) {
  const double fading = fading_share * reach.radius;
  if ((foot.x - sight.place.x).norm() > fading) return Answer::no;
  for (int k = 0; k < dim; ++k) {
    if (foot.weights[k] >= 0) continue;
    const Answer bends = bends_inwards<dim>(front, sight, k, reach.distance + fading);
    if (bends != Answer::yes) return bends;
  }
  return Answer::yes;
}

// See find_features. @param within  largest distance of the foot on its own simplex [m]
template <int dim>
void move_to_nearest(const Front<dim>& front, double within, SurfaceFeature<dim>& foot) {
  const FacingSurface<dim>& surface = front.surface();
  double nearest = std::numeric_limits<double>::infinity();
  const Vector<dim> place_of_foot = foot.x;
  for (const FacingSimplex& facing : surface.facing) {
    const std::int32_t s = facing.simplex;
    if (front.is_beyond(s, place_of_foot, within)) continue;
    const auto corners = corners_of<dim>(surface.simplices[s], surface.end);
    const auto place = closest_place<dim>(corners, place_of_foot);
    const double distance = (place.x - place_of_foot).squaredNorm();
    if (distance >= nearest) continue;
    nearest = distance;
    foot.simplex = s;
    foot.weights = place.weights;
  }
}

// Whether the point is behind none of the simplices seen, nor behind farther ones.
template <int dim>
bool is_in_front(const std::vector<Sight<dim>>& sights, bool has_touched, double reach) {
  for (const Sight<dim>& sight : sights) {
    if (sight.height > 0 || sight.was_behind) continue;
    if (sight.crossed || sight.place.num_corners() == dim) return false;
  }
  if (!has_touched) return true;
  const Sight<dim>* touched = nearest_touched<dim>(sights);
  return touched && touched->distance < (1 - rounding) * reach &&
         (touched->height > 0 || !touched->was_behind);
}

}  // namespace

// Radius within which the point may come behind a simplex: its displacement, or twice that where
// simplices turn, by less than 60 degrees in the step.
template <int dim>
double front_reach(const FacingSurface<dim>& surface, const FeatureReach& reach, double path) {
  const double behind = surface.motion > 0 ? 2 * (path + surface.motion) : path;
  const double fading = fading_share * reach.radius;
  return (1 + rounding) * std::max(reach.distance + fading + surface.seam, behind);
}

template <int dim>
void faced_near(const FrontView<dim>& view, const Vector<dim>& x, const NearPlace<dim>& near,
                std::vector<FacingSimplex>& list) {
  list.clear();
  const Path<dim> path{x, x};
  const Front<dim> front(view, path);
  FacingSimplex facing;
  for (const std::int32_t s : near.simplices) {
    const SimplexBounds<dim>& bounds = view.bounds[s];
    if (bounds.is_beyond(near.place, near.distance) || !front.faces(s, facing)) continue;
    facing.distance = (near.place - bounds.centre).norm() - bounds.radius;
    list.push_back(facing);
  }
}

template <int dim>
bool features_in_front(const FrontView<dim>& view, const Vector<dim>& x, const Vector<dim>& y,
                       const FeatureReach& reach, std::vector<SurfaceFeature<dim>>& features) {
  features.clear();
  const FacingSurface<dim>& surface = view.surface;
  const double fading = fading_share * reach.radius;
  const double farthest =
      std::max(view.around, front_reach<dim>(surface, {reach.distance, 0}, (y - x).norm()));
  const Path<dim> path{x, y};
  const Front<dim> front(view, path);
  thread_local std::vector<Sight<dim>> sights;
  sights.clear();
  for (const FacingSimplex& facing : surface.facing) {
    if (front.is_beyond(facing, farthest)) continue;
    sights.push_back(sight_of<dim>(surface, facing, path, front.normal(facing.simplex)));
  }
  if (!is_in_front<dim>(sights, !view.touched.empty(), farthest)) return false;
  for (const Sight<dim>& sight : sights) {
    if (!(sight.height > 0 && sight.distance < reach.distance)) continue;
    if (is_minimum<dim>(surface, sight, sights)) {
      const auto feature = feature_of<dim>(sight, y);
      if (is_new<dim>(feature, features, reach.distance)) features.push_back(feature);
      continue;
    }
    auto foot = foot_of<dim>(surface, sight, y);
    const Answer fades = fades_out<dim>(front, sight, foot, reach);
    if (fades == Answer::unknown) return false;
    if (fades == Answer::no) continue;
    move_to_nearest<dim>(front, (1 + rounding) * fading, foot);
    features.push_back(foot);
  }
  return true;
}

template void faced_near<2>(const FrontView<2>&, const Vector<2>&, const NearPlace<2>&,
                            std::vector<FacingSimplex>&);
template void faced_near<3>(const FrontView<3>&, const Vector<3>&, const NearPlace<3>&,
                            std::vector<FacingSimplex>&);
template double front_reach<2>(const FacingSurface<2>&, const FeatureReach&, double);
template double front_reach<3>(const FacingSurface<3>&, const FeatureReach&, double);
template bool features_in_front<2>(const FrontView<2>&, const Vector<2>&, const Vector<2>&,
                                   const FeatureReach&, std::vector<SurfaceFeature<2>>&);
template bool features_in_front<3>(const FrontView<3>&, const Vector<3>&, const Vector<3>&,
                                   const FeatureReach&, std::vector<SurfaceFeature<3>>&);

}  // namespace gabion::mpm
