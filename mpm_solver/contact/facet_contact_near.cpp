// SPDX-License-Identifier: BSD-3-Clause
// What of a contact by facets a point touches, looked for where it comes near.
#include <algorithm>
#include <cmath>
#include <limits>

#include "mpm_solver/contact/facet_contact.hpp"
#include "mpm_solver/contact/surface_sights.hpp"

namespace gabion::mpm {

namespace {

// What is nearer than a limit to within this share of it may be beyond it by rounding.
constexpr double rounding = 1e-9;

// Sum of |grad N_i| of a point, or more.
template <int dim>
double sum_of_gradients(const SoilSurface<dim>& soil, const CellGroup& group, std::int32_t entry) {
  if (soil.grid.box) return 2 * soil.grid.box->spacing.cwiseInverse().sum();
  const PointWeights<dim>& weights = soil.weights;
  const Vector<dim>* grad = weights.grad_of(weights.constant_gradient ? group.first : entry);
  double sum = 0;
  for (int i = 0; i < weights.num_nodes(entry); ++i) sum += grad[i].norm();
  return sum;
}

}  // namespace

template <int dim>
void FacetContact<dim>::find_touches(std::span<const double> du) {
  du_.assign(du.begin(), du.end());
  at_rest_.clear();
  for (const Member& member : members_) at_rest_.push_back(member.motion == 0 ? 1 : 0);
  for (const WatchedGroup& watched : watched_groups_) {
    const CellGroup& group = soil_->weights.groups[watched.group];
    const NodalBox box = box_of(group, du);
    if (stays_away(watched, box)) continue;
    for (std::int32_t k = watched.first; k < watched.last; ++k) {
      Watched& point = watched_[k];
      if (stays_away(point, group, box)) continue;
      complete(point, group);
      find_touches_of(point.candidate, du);
    }
  }
}

template <int dim>
typename FacetContact<dim>::NodalBox FacetContact<dim>::box_of(const CellGroup& group,
                                                               std::span<const double> du) const {
  const auto list = soil_->weights.nodes_of(group);
  const auto nodes = std::span(soil_->nodes.of_groups).subspan(list.first, list.size());
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Vector<dim> low = Vector<dim>::Constant(infinity), high = -low;
  for (const std::int32_t node : nodes) {
    const Eigen::Map<const Vector<dim>> du_i(du.data() + std::ptrdiff_t{node} * dim);
    low = low.cwiseMin(du_i);
    high = high.cwiseMax(du_i);
  }
  return {.middle = 0.5 * (low + high), .half = 0.5 * (high - low)};
}

// Whether find_features would surely find nothing: the point touched nothing when the step began,
// and no simplex is in reach at its end, nor one that it may have come behind (front_reach).
// @param box  of the displacements of its nodes
template <int dim>
bool FacetContact<dim>::stays_away(const Watched& point, const CellGroup& group,
                                   const NodalBox& box) const {
  if (point.candidate >= 0) {
    const Candidate& c = candidates_[point.candidate];
    if (c.memory || c.deforms) return false;
  }
  const double spread = box.half.norm();
  const double way = box.middle.norm() + spread + surface_motion_;
  const double behind = surface_motion_ > 0 ? 2 * way : way;
  const double nearest = search_.at_least(point.x + box.middle, box.half) - surface_motion_;
  if (!(nearest > (1 + rounding) * std::max(point.reach + 2 * spread, behind))) return false;
  const double strained =
      spread * sum_of_gradients(*soil_, group, point.entry) * point.reach;  // |H| |shape|
  return nearest > (1 + rounding) * (point.reach + strained);
}

// The same of all points of a group.
template <int dim>
bool FacetContact<dim>::stays_away(const WatchedGroup& watched, const NodalBox& box) const {
  const double spread = box.half.norm();
  const double way = box.middle.norm() + spread + surface_motion_;
  const double nearest = watched.clearance - way, behind = surface_motion_ > 0 ? 2 * way : way;
  if (!(nearest > (1 + rounding) * std::max(watched.reach + 2 * spread, behind))) return false;
  const CellGroup& group = soil_->weights.groups[watched.group];
  double gradients = 0;
  if (soil_->grid.box) {
    gradients = sum_of_gradients(*soil_, group, group.first);
  } else {
    for (std::int32_t k = watched.first; k < watched.last; ++k) {
      gradients = std::max(gradients, sum_of_gradients(*soil_, group, watched_[k].entry));
    }
  }
  return nearest > (1 + rounding) * watched.reach * (1 + spread * gradients);
}

template <int dim>
void FacetContact<dim>::find_touches_of(std::int32_t candidate, std::span<const double> du) {
  Candidate& c = candidates_[candidate];
  Vector<dim> motion = Vector<dim>::Zero();
  Matrix<dim> H = Matrix<dim>::Zero();
  for (std::int32_t k = c.first_value; k < c.first_value + c.num_values; ++k) {
    const Eigen::Map<const Vector<dim>> du_k(du.data() + std::ptrdiff_t{nodes_[k]} * dim);
    motion += N_[k] * du_k;
    H += du_k * grad_N_[k].transpose();
  }
  c.motion = motion;
  c.H = H;
  double spread = 0;
  for (std::int32_t k = c.first_value; k < c.first_value + c.num_values; ++k) {
    const Eigen::Map<const Vector<dim>> du_k(du.data() + std::ptrdiff_t{nodes_[k]} * dim);
    spread = std::max(spread, (du_k - motion).squaredNorm());
  }
  c.spread = std::sqrt(spread);
  const double reach = reach_of(c);
  const double shorter = c.reaches_far ? reach : std::min(reach, touch_reach(c));
  find_features_of(c, shorter);
  c.found = !features_.empty();
  const std::size_t first = touches_.size();
  for (const auto& feature : features_) {
    Touch touch = touch_at(c, feature, du);
    touch.candidate = candidate;
    if (touch.gap >= 0) {
      w_.resize(touch.first_weight);
      if (c.reaches_far) opened_.push_back(touch);
      continue;
    }
    touches_.push_back(touch);
  }
  share_in_corners(c, first);
}

// How far from the centre of its ball, at the end of its way, a point feels the surface: the
// surface of the ball goes against the centre by no more than its nodes, or its strain, do.
template <int dim>
double FacetContact<dim>::reach_of(const Candidate& c) const {
  const double against_centre = std::max(c.H.norm() * c.shape.norm(), c.spread);
  return c.shape.norm() + against_centre + c.offset.norm() + most_begun(c);
}

// How far a place may be that it touches, if the ball is rigid: the plane of a simplex pushes a
// little beyond its end (find_features).
template <int dim>
double FacetContact<dim>::touch_reach(const Candidate& c) const {
  const double size = c.shape.norm() + c.offset.norm(), R = mean_radius(c);
  const double height = R + c.spread + 2 * c.H.norm() * size + c.offset.norm() + most_begun(c);
  return (1 + rounding) * std::hypot(height, sights::fading_share * R);
}

// Places where the balls stand off from the surface at the end of the step: of those that are
// rigid, which add_forces looks no farther ahead for than they may touch.
template <int dim>
void FacetContact<dim>::find_opened() {
  if (du_.empty()) return;
  for (const WatchedGroup& watched : watched_groups_) {
    for (std::int32_t k = watched.first; k < watched.last; ++k) {
      if (watched_[k].candidate < 0) continue;
      Candidate& c = candidates_[watched_[k].candidate];
      if (c.reaches_far || !(c.found || !c.offset.isZero(0))) continue;
      find_features_of(c, reach_of(c));
      for (const auto& feature : features_) {
        Touch touch = touch_at(c, feature, du_);
        touch.candidate = watched_[k].candidate;
        if (touch.gap >= 0) opened_.push_back(touch);
      }
    }
  }
}

// Whether the point is in front of the nearest simplex of those that it touched.
template <int dim>
typename FacetContact<dim>::Place FacetContact<dim>::place_of(Candidate& c) {
  if (!c.memory) return Place::front;
  double nearest = std::numeric_limits<double>::infinity(), height = 0;
  for (const std::int32_t s : search_.near(c.x, search_.reach(), near_)) {
    const SimplexBounds<dim>& bounds = search_.bounds()[s];
    if (bounds.is_beyond(c.x, std::min(nearest, c.margin))) continue;
    if (!remembered(c, bounds.normal, owner_[s])) continue;
    const auto corners = corners_of<dim>(simplices_[s], start_);
    const double distance = (closest_place<dim>(corners, c.x).x - c.x).norm();
    if (distance >= nearest) continue;
    nearest = distance;
    height = (c.x - corners[0]).dot(bounds.normal);
  }
  c.touched_distance = nearest;
  const bool known = nearest < (1 - rounding) * search_.reach();
  return known && height > 0 ? Place::front : Place::other;
}

// @param around  see FrontView
template <int dim>
bool FacetContact<dim>::look_in_front(const Candidate& c, const FeatureReach& reach,
                                      double around) {
  const auto surface = surface_of(c, end_);
  const Vector<dim> y = c.x + c.motion;
  const double needed = std::max(around, front_reach<dim>(surface, reach, c.motion.norm()));
  known_.clear();
  if (c.memory) {
    for (const Memory& memory : *c.memory) known_.push_back({memory.owner, memory.normal});
  }
  const FrontView<dim> view{.surface = surface,
                            .bounds = search_.bounds(),
                            .neighbours = neighbours_,
                            .at_rest = at_rest_,
                            .near = search_.near(y, needed + surface_motion_, near_),
                            .touched = known_,
                            .around = around,
                            .margin = c.margin};
  return features_in_front<dim>(view, c.x, y, reach, features_);
}

// A point that came off may have what it touched farther away than its reach.
template <int dim>
void FacetContact<dim>::find_features_of(Candidate& c, double reach) {
  const FeatureReach feature_reach{reach, mean_radius(c)};
  if (c.place == Place::unknown) c.place = place_of(c);
  if (c.place == Place::front) {
    if (look_in_front(c, feature_reach, 0)) return;
    const double touched = (1 + 2e-6) * (c.touched_distance + c.motion.norm() + surface_motion_);
    if (c.memory && touched < c.margin && look_in_front(c, feature_reach, touched)) return;
  }
  list_facing(c);
  features_.clear();
  if (c.distance - c.motion.norm() - surface_motion_ > reach) return;
  find_features<dim>(surface_of(c, end_), c.x, c.x + c.motion, feature_reach, features_);
}

template class FacetContact<2>;
template class FacetContact<3>;

}  // namespace gabion::mpm
