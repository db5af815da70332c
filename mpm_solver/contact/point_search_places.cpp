// SPDX-License-Identifier: BSD-3-Clause
// Places that the points may touch, looked for where they come near.
#include <algorithm>
#include <cmath>
#include <limits>

#include "mpm_solver/contact/point_search.hpp"
#include "mpm_solver/contact/surface_sights.hpp"

namespace gabion::mpm {

namespace {

// Distances within this share of a limit may be on either side of it by rounding.
constexpr double rounding = 1e-9;

// The simplices that a candidate faces are listed farther than needed, by this share of the needed
// distance and of the displacement still ahead in the step.
constexpr double listed_ahead = 0.1;

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

// Largest initial penetration.
template <int dim>
double largest_initial_penetration(const RememberedContacts<dim>* contacts) {
  double most = 0;
  if (!contacts) return most;
  for (const auto& contact : *contacts) most = std::max(most, contact.initial_penetration());
  return most;
}

template <int dim>
NodalBox<dim> box_of(const SoilSurface<dim>& soil, const CellGroup& group,
                     std::span<const double> du) {
  const auto list = soil.weights.nodes_of(group);
  const auto nodes = std::span(soil.nodes.of_groups).subspan(list.first, list.size());
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Vector<dim> low = Vector<dim>::Constant(infinity), high = -low;
  for (const std::int32_t node : nodes) {
    const Eigen::Map<const Vector<dim>> du_i(du.data() + std::ptrdiff_t{node} * dim);
    low = low.cwiseMin(du_i);
    high = high.cwiseMax(du_i);
  }
  return {.middle = 0.5 * (low + high), .half = 0.5 * (high - low)};
}

// Distance from the centre of its sphere, at the end of its displacement path, within which a
// surface acts on a point: the surface of the sphere moves against the centre by no more than its
// nodes, or its strain, do.
template <int dim>
double reach_of(const ContactCandidate<dim>& c) {
  const double against_centre = std::max(c.H.norm() * c.shape.norm(), c.spread);
  return c.shape.norm() + against_centre + c.offset.norm() +
         largest_initial_penetration<dim>(c.memory);
}

// Largest distance of a contact point, if the sphere is rigid: the plane of a simplex pushes a
// little beyond its end (find_features).
template <int dim>
double touch_reach(const ContactCandidate<dim>& c) {
  const double size = c.shape.norm() + c.offset.norm(), R = c.mean_radius();
  const double height = R + c.spread + 2 * c.H.norm() * size + c.offset.norm() +
                        largest_initial_penetration<dim>(c.memory);
  return (1 + rounding) * std::hypot(height, sights::fading_share * R);
}

}  // namespace

template <int dim>
void PointSearch<dim>::surface_weights(const Candidate& c, const Vector<dim>& n, double* w) const {
  Vector<dim> d = c.offset - c.radius(n) * n;
  const double* N = N_.data() + c.first_value;
  if (c.surface) {
    d -= c.surface->at(n, -n.dot(d), w);
    N = w;
  }
  for (std::int32_t k = 0; k < c.num_values; ++k) w[k] = N[k] + grad_N_[c.first_value + k].dot(d);
}

template <int dim>
void PointSearch<dim>::scatter(const Candidate& c, const double* w, const Vector<dim>& f,
                               std::span<double> field) const {
  for (std::int32_t k = 0; k < c.num_values; ++k) {
    const std::ptrdiff_t node = nodes_[c.first_value + k];
    Eigen::Map<Vector<dim>>(field.data() + node * dim) += w[k] * f;
  }
}

template <int dim>
void PointSearch<dim>::motions_of_nodes(const Candidate& c,
                                        std::vector<Vector<dim>>& motions) const {
  motions.clear();
  for (const std::int32_t node : nodes_of(c)) motions.push_back(du_.at(node));
}

template <int dim>
void PointSearch<dim>::end_step() {
  soil_.reset();
  forget_watched();
  facing_.clear();
  around_.clear();
  du_.clear();
}

template <int dim>
void PointSearch<dim>::find(std::span<const double> du, const Take& take) {
  if (watched_groups_.empty()) return;
  du_.set(du);
  at_rest_.clear();
  for (std::int32_t m = 0; m < surface_.num_members(); ++m) {
    at_rest_.push_back(surface_.member(m).motion == 0 ? 1 : 0);
  }
  for (const WatchedGroup& watched : watched_groups_) {
    const CellGroup& group = soil_->weights.groups[watched.group];
    const NodalBox<dim> box = box_of(*soil_, group, du);
    if (stays_away(watched, box)) continue;
    for (std::int32_t k = watched.first; k < watched.last; ++k) {
      Watched& point = watched_[k];
      if (stays_away(point, group, box)) continue;
      find_of(complete(point, group), du);
      take(point.candidate, features_);
    }
  }
}

// Whether find_features would surely find nothing: the point had no contact when the step began,
// and at its end no simplex is in reach, nor one that it may have come behind (front_reach).
// @param box  of the displacements of its nodes
template <int dim>
bool PointSearch<dim>::stays_away(const Watched& point, const CellGroup& group,
                                  const NodalBox<dim>& box) const {
  if (point.candidate >= 0) {
    const Candidate& c = candidates_[point.candidate];
    if (c.memory || c.deforms) return false;
  }
  const double spread = box.half.norm();
  const double path = box.middle.norm() + spread + surface_.motion();
  const double behind = surface_.motion() > 0 ? 2 * path : path;
  const double strained =
      spread * sum_of_gradients(*soil_, group, point.entry) * point.reach;  // |H| |shape|
  const double least =
      (1 + rounding) * std::max({point.reach + 2 * spread, behind, point.reach + strained});
  if (point.clearance - path > least) return true;
  const auto& search = surface_.search();
  return search.at_least(point.x + box.middle, box.half) - surface_.motion() > least;
}

// stays_away() for all points of a group.
template <int dim>
bool PointSearch<dim>::stays_away(const WatchedGroup& watched, const NodalBox<dim>& box) const {
  const double spread = box.half.norm();
  const double path = box.middle.norm() + spread + surface_.motion();
  const double nearest = watched.clearance - path, behind = surface_.motion() > 0 ? 2 * path : path;
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
void PointSearch<dim>::find_of(Candidate& c, std::span<const double> du) {
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
}

template <int dim>
void PointSearch<dim>::find_opened(const Take& take) {
  if (du_.empty()) return;
  for (const WatchedGroup& watched : watched_groups_) {
    for (std::int32_t k = watched.first; k < watched.last; ++k) {
      if (watched_[k].candidate < 0) continue;
      Candidate& c = candidates_[watched_[k].candidate];
      if (c.reaches_far || !(c.found || !c.offset.isZero(0))) continue;
      find_features_of(c, reach_of(c));
      take(watched_[k].candidate, features_);
    }
  }
}

// Whether the point is in front of the nearest simplex with which it was in contact.
template <int dim>
typename PointSearch<dim>::Place PointSearch<dim>::place_of(Candidate& c) {
  if (!c.memory) return Place::front;
  double nearest = std::numeric_limits<double>::infinity(), height = 0;
  for (const std::int32_t s : surface_.search().near(c.x, surface_.search().reach(), near_)) {
    const SimplexBounds<dim>& bounds = surface_.search().bounds()[s];
    if (bounds.is_beyond(c.x, std::min(nearest, c.margin))) continue;
    if (!going_on(c.memory, bounds.normal, surface_.owner(s))) continue;
    const auto corners = surface_.corners(s);
    const double distance = (closest_place<dim>(corners, c.x).x - c.x).norm();
    if (distance >= nearest) continue;
    nearest = distance;
    height = (c.x - corners[0]).dot(bounds.normal);
  }
  c.touched_distance = nearest;
  const bool known = nearest < (1 - rounding) * surface_.search().reach();
  return known && height > 0 ? Place::front : Place::other;
}

// The simplices that the candidate faces around the end of its displacement path, listed for the
// step; the list is made anew where the path leads farther.
// @param needed  all within this distance of the end of the path have to be listed [m]
// @returns see FrontView::nearer
template <int dim>
double PointSearch<dim>::list_around(Candidate& c, const FrontView<dim>& view, double needed) {
  auto& around = c.around;
  const Vector<dim> y = c.x + c.motion;
  const double nearer = (y - around.place).norm() + surface_.motion();
  if (needed + nearer <= around.within) return nearer;
  const double ahead = c.motion.norm() * (1 / surface_.share() - 1);
  const double required = (1 + rounding) * (needed + surface_.motion());
  const double wanted = required + ahead + listed_ahead * (ahead + needed);
  around.place = y;
  around.within = std::max(required, std::min(wanted, surface_.search().reach()));
  const auto near = surface_.search().near(y, around.within, near_);
  faced_near<dim>(view, c.x, {y, around.within, near}, faced_);
  around.count = static_cast<std::int32_t>(faced_.size());
  if (around.count > around.room) {
    around.first = static_cast<std::int32_t>(around_.size());
    around.room = around.count;
    around_.resize(around_.size() + faced_.size());
  }
  std::ranges::copy(faced_, around_.begin() + around.first);
  return surface_.motion();
}

// @param around  see FrontView
template <int dim>
bool PointSearch<dim>::look_in_front(Candidate& c, const FeatureReach& reach, double around) {
  auto surface = view_of(c);
  const Vector<dim> y = c.x + c.motion;
  const double needed = std::max(around, front_reach<dim>(surface, reach, c.motion.norm()));
  known_.clear();
  add_known(c.memory, known_);
  FrontView<dim> view{.surface = surface,
                      .bounds = surface_.search().bounds(),
                      .neighbours = surface_.neighbours(),
                      .at_rest = at_rest_,
                      .touched = known_,
                      .around = around,
                      .margin = c.margin};
  view.nearer = list_around(c, view, needed);
  surface.facing = std::span(around_).subspan(c.around.first, c.around.count);
  return features_in_front<dim>(view, c.x, y, reach, features_);
}

// A point that came off may be farther away from its former contact than its reach.
template <int dim>
void PointSearch<dim>::find_features_of(Candidate& c, double reach) {
  const FeatureReach feature_reach{reach, c.mean_radius()};
  if (c.place == Place::unknown) c.place = place_of(c);
  if (c.place == Place::front) {
    if (look_in_front(c, feature_reach, 0)) return;
    const double touched = (1 + 2e-6) * (c.touched_distance + c.motion.norm() + surface_.motion());
    if (c.memory && touched < c.margin && look_in_front(c, feature_reach, touched)) return;
  }
  list_facing(c);
  features_.clear();
  if (c.distance - c.motion.norm() - surface_.motion() > reach) return;
  find_features<dim>(view_of(c), c.x, c.x + c.motion, feature_reach, features_);
}

// The displacement of a point in the last add_forces [m].
template <int dim>
Vector<dim> PointSearch<dim>::motion_of(std::int32_t entry, const CellGroup& group) const {
  Vector<dim> motion = Vector<dim>::Zero();
  if (du_.empty()) return motion;
  const PointWeights<dim>& weights = soil_->weights;
  const double* N = weights.N_of(entry);
  const std::uint8_t* local = weights.local_of(entry);
  const std::int32_t first = weights.nodes_of(group).first;
  for (int i = 0; i < weights.num_nodes(entry); ++i) {
    motion += N[i] * du_.at(soil_->nodes.of_groups[first + local[i]]);
  }
  return motion;
}

// A point without contact that is far away, or slow, cannot require the smallest step.
template <int dim>
double PointSearch<dim>::approach_step(double dt, double margin) const {
  double result = std::numeric_limits<double>::infinity();
  for (const WatchedGroup& watched : watched_groups_) {
    const CellGroup& group = soil_->weights.groups[watched.group];
    for (std::int32_t k = watched.first; k < watched.last; ++k) {
      const Watched& point = watched_[k];
      const Vector<dim> motion = motion_of(point.entry, group);
      if (point.candidate < 0) {
        const double closing = motion.norm() + surface_.motion();  // or less
        const double nearest = surface_.search().far_at_least(point.x, Vector<dim>::Zero());
        const double gap = std::max(nearest - closing - point.reach, 0.0);
        if (dt * (gap + margin) > 1.001 * result * closing) continue;
      }
      const Candidate c =
          point.candidate < 0 ? candidate_of(point, group) : candidates_[point.candidate];
      const Facing facing = facing_of(c);
      if (facing.simplices.empty()) continue;
      for (const Near& near : facing.near) {
        const Vector<dim>& n = near.place.normal;
        const double closing = n.dot(surface_.motion_at(near.place) - motion);
        const double gap = near.distance - closing - c.radius(n);
        if (closing > 0) result = std::min(result, dt * (std::max(gap, 0.0) + margin) / closing);
      }
    }
  }
  return result;
}

template class PointSearch<2>;
template class PointSearch<3>;

}  // namespace gabion::mpm
