// SPDX-License-Identifier: BSD-3-Clause
// Which points are watched in a step, and what they face.
#include "mpm_solver/contact/point_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "mpm_solver/contact/soil_extent.hpp"
#include "mpm_solver/grid/fastest_about.hpp"

namespace gabion::mpm {

namespace {

// Share of a cell by which soil and surface may come nearer than their speeds say; beyond it the
// search was too short and the step is refused.
constexpr double watched_share = 0.5;

// Rims that are nearer to a surface than this share of a sphere's radius meet it.
constexpr double seam_share = 1e-3;

constexpr double infinity = std::numeric_limits<double>::infinity();

// Distance at which the clearance of a group tells that none of its points is in contact, in
// displacements of these points by their speed.
constexpr double far_ways = 2;

// Distances within this share of a limit may be on either side of it by rounding.
constexpr double rounding = 1e-9;

// The nodes of watched groups, ascending; none where they may be more than half of all nodes.
template <int dim, class WatchedGroups>
std::vector<std::int32_t> nodes_of_few(const SoilSurface<dim>& soil, const WatchedGroups& watched) {
  std::vector<std::int32_t> nodes;
  for (const auto& each : watched) {
    const CellGroup& group = soil.weights.groups[each.group];
    const auto first = soil.nodes.of_groups.begin() + group.first_node;
    nodes.insert(nodes.end(), first, first + group.num_nodes);
    if (2 * std::ssize(nodes) > soil.nodes.size()) return {};
  }
  std::ranges::sort(nodes);
  const auto rest = std::ranges::unique(nodes);
  nodes.erase(rest.begin(), rest.end());
  return nodes;
}

}  // namespace

template <int dim>
void PointSearch<dim>::begin_step(const SoilSurface<dim>& soil, double deepest) {
  end_step();
  soil_.emplace(soil);
  bool acts = false;
  for (std::int32_t m = 0; m < surface_.num_members(); ++m) acts |= !surface_.member(m).dropped;
  if (!acts) return;
  if (!soil_->extent) soil_->extent = std::make_shared<SoilExtent<dim>>(soil);
  const double widest = soil_->extent->widest();
  double watched = 0;
  for (std::int32_t m = 0; m < surface_.num_members(); ++m) {
    limits_[m] = {.watched = watched_share * soil.cell_size + 2 * surface_.member(m).last_motion};
    watched = std::max(watched, limits_[m].watched);
  }
  margin_ = watched + deepest + widest;
  box_ = surface_.begin_step(widest);
  watch_points(margin_ + 2 * soil.dt * soil_->extent->fastest());
}

template <int dim>
void PointSearch<dim>::forget_watched() {
  watched_.clear();
  watched_groups_.clear();
  num_known_ = 0;
  candidates_.clear();
  N_.clear();
  grad_N_.clear();
  nodes_.clear();
}

template <int dim>
double PointSearch<dim>::allowed_motion(std::size_t member) const {
  const auto& own = surface_.member(member);
  return own.dropped ? infinity : limits_[member].watched - own.motion;
}

// Watch the groups of points near the surface, and what the memory knows: others face nothing.
// @param margin  places farther from all points than this are out of reach [m]
template <int dim>
void PointSearch<dim>::watch_points(double margin) {
  farthest_ = margin;
  memory_.make_index();
  const Vector<dim> around = Vector<dim>::Constant(margin);
  auto groups = soil_->extent->groups_in({box_.min() - around, box_.max() + around});
  if (!groups.empty()) watch_groups(groups, margin);
  if (num_known_ < memory_.num_known()) {
    forget_watched();
    groups.resize(soil_->weights.groups.size());
    std::iota(groups.begin(), groups.end(), 0);
    watch_groups(groups, margin);
  }
  du_.keep_at(nodes_of_few(*soil_, watched_groups_));
}

// @param groups  numbers, ascending
template <int dim>
void PointSearch<dim>::watch_groups(std::span<const std::int32_t> groups, double margin) {
  surface_.make_ready();
  const SoilSurface<dim>& soil = *soil_;
  for (const std::int32_t g : groups) {
    const CellGroup& group = soil.weights.groups[g];
    const auto first = static_cast<std::int32_t>(watched_.size());
    for (std::int32_t e = group.first; e < group.last; ++e) {
      Watched point = watched(e);
      if (point.memory || point.offset) ++num_known_;
      const bool deforms = soil.elastic[group.body] != 0;
      if (deforms && !point.memory && !is_near(point.x, margin)) continue;
      if (deforms || point.memory) complete(point, group);
      mark_touching(point, group);
      watched_.push_back(point);
    }
    add_group(g, first);
  }
}

// @param first  of its points, which were watched last
template <int dim>
void PointSearch<dim>::add_group(std::int32_t group, std::int32_t first) {
  const auto last = static_cast<std::int32_t>(watched_.size());
  if (last == first) return;
  WatchedGroup result{.group = group, .first = first, .last = last, .clearance = infinity};
  double fastest = 0;
  Vector<dim> low = Vector<dim>::Constant(infinity), high = -low;
  for (std::int32_t k = first; k < last; ++k) {
    const Watched& point = watched_[k];
    low = low.cwiseMin(point.x);
    high = high.cwiseMax(point.x);
    result.reach = std::max(result.reach, point.candidate < 0 ? point.reach : infinity);
    result.clearance = std::min(result.clearance, point.clearance);
    fastest = std::max(fastest, soil_->points.v[soil_->weights.point[point.entry]].norm());
  }
  const bool is_far = result.reach < infinity && result.clearance >= surface_.search().reach();
  if (is_far && result.clearance < result.reach + far_ways * soil_->dt * fastest) {
    const Vector<dim> middle = 0.5 * (low + high), half = 0.5 * (high - low);
    result.clearance = std::max(result.clearance, surface_.search().far_at_least(middle, half));
  }
  watched_groups_.push_back(result);
}

template <int dim>
typename PointSearch<dim>::Watched PointSearch<dim>::watched(std::int32_t entry) const {
  const SoilSurface<dim>& soil = *soil_;
  const std::int32_t p = soil.weights.point[entry];
  Watched point{.entry = entry, .x = soil.points.x[p]};
  const auto known = memory_.known(soil.points.id[p]);
  point.memory = known.contacts;
  point.offset = known.offset;
  double offset = 0;
  if (point.offset) {
    point.x += *point.offset;
    offset = point.offset->norm();
  }
  point.reach = soil.points.depth[p] * std::sqrt(double{dim}) + offset;
  point.clearance = surface_.search().at_least(point.x, Vector<dim>::Zero());
  return point;
}

template <int dim>
bool PointSearch<dim>::is_near(const Vector<dim>& x, double margin) {
  const auto near = surface_.search().near(x, margin, near_);
  return std::ranges::any_of(
      near, [&](std::int32_t s) { return !surface_.search().bounds()[s].is_beyond(x, margin); });
}

// A candidate without its basis functions.
template <int dim>
typename PointSearch<dim>::Candidate PointSearch<dim>::candidate_of(const Watched& point,
                                                                    const CellGroup& group) const {
  const SoilSurface<dim>& soil = *soil_;
  const std::int32_t p = soil.weights.point[point.entry];
  Candidate c;
  c.id = soil.points.id[p];
  c.body = group.body;
  c.x = point.x;
  if (point.offset) c.offset = *point.offset;
  c.deforms = soil.elastic[group.body] != 0;
  c.modulus = soil.moduli[group.body];
  c.volume = soil.points.V0[p] * (c.deforms ? soil.points.J[p] : 1);
  c.shape = memory_.shape(c.id, soil.points.depth[p]);
  c.memory = point.memory;
  c.took_weight = took_weight(c.memory, soil.takes_weight);
  if (c.took_weight) c.weight = soil.weights_of[group.body];
  if (!soil.pore_pressures.empty()) {
    c.pore_pressure = soil.pore_pressures[p];
    c.grain_stress = soil.grain_stresses[p];
  }
  c.reaches_far = c.deforms || soil.grid.basis == Basis::bspline;
  c.margin = margin_ + 2 * soil_->dt *
                           fastest_about(soil.points, soil.weights, soil.nodes, group, point.entry);
  return c;
}

template <int dim>
typename PointSearch<dim>::Candidate& PointSearch<dim>::complete(Watched& point,
                                                                 const CellGroup& group) {
  if (point.candidate >= 0) return candidates_[point.candidate];
  const SoilSurface<dim>& soil = *soil_;
  point.candidate = static_cast<std::int32_t>(candidates_.size());
  Candidate& c = candidates_.emplace_back(candidate_of(point, group));
  if (soil.grid.basis != Basis::linear) {
    c.surface.emplace(soil.grid, soil.points, soil.weights.point[point.entry]);
  }
  add_values(group, point.entry);
  return c;
}

// Basis functions of the candidate added last.
template <int dim>
void PointSearch<dim>::add_values(const CellGroup& group, std::int32_t entry) {
  const SoilSurface<dim>& soil = *soil_;
  const PointWeights<dim>& weights = soil.weights;
  const int n = weights.num_nodes(entry);
  const std::uint8_t* local = weights.local_of(entry);
  const Vector<dim>* grad = weights.grad_of(weights.constant_gradient ? group.first : entry);
  Candidate& c = candidates_.back();
  c.first_value = static_cast<std::int32_t>(N_.size());
  c.num_values = n;
  N_.insert(N_.end(), weights.N_of(entry), weights.N_of(entry) + n);
  grad_N_.insert(grad_N_.end(), grad, grad + n);
  const auto group_nodes = weights.nodes_of(group);
  for (int i = 0; i < n; ++i) nodes_.push_back(soil.nodes.active[group_nodes[local[i]]]);
}

// Members that the point may meet in the step, by its speed at the start.
template <int dim>
void PointSearch<dim>::mark_touching(const Watched& point, const CellGroup& group) {
  if (point.memory) {
    for (const auto& contact : *point.memory) limits_[contact.owner].may_touch = true;
  }
  const SoilSurface<dim>& soil = *soil_;
  const double speed = soil.points.v[soil.weights.point[point.entry]].norm() * soil.dt;
  std::optional<Facing> facing;
  for (std::int32_t m = 0; m < surface_.num_members(); ++m) {
    Limits& limits = limits_[m];
    const auto& member = surface_.member(m);
    if (limits.may_touch || member.dropped) continue;
    const auto reach = [&](double sphere) {
      return sphere + 2 * speed + 0.05 * soil.cell_size + 2 * member.last_motion;
    };
    const double nearest = surface_.search().at_least(m, point.x, Vector<dim>::Zero());
    if (!point.memory && !soil.elastic[group.body] &&
        nearest > (1 + rounding) * reach(point.reach)) {
      continue;
    }
    const Candidate c = candidate_of(point, group);
    if (!facing) facing = facing_of(c);
    for (const Near& near : facing->near) {
      if (near.owner != m) continue;
      limits.may_touch |= near.distance < reach(c.shape.norm() + c.offset.norm());
    }
  }
}

template <int dim>
void PointSearch<dim>::complete_near(double distance) {
  const double margin = std::max(margin_, distance);
  if (margin > farthest_) {
    forget_watched();
    watch_points(margin);
  }
  for (WatchedGroup& watched : watched_groups_) {
    const CellGroup& group = soil_->weights.groups[watched.group];
    for (std::int32_t k = watched.first; k < watched.last; ++k) {
      if (is_near(watched_[k].x, margin)) complete(watched_[k], group);
    }
    watched.reach = infinity;
  }
}

// A point can be in contact only with facets that it is in front of: not with those behind which it
// is, such as the far face of a thin structure. A point whose centre went through the face that it
// met still belongs to that face.
template <int dim>
typename PointSearch<dim>::Facing PointSearch<dim>::facing_of(const Candidate& c) const {
  Facing facing;
  facing.distance = infinity;
  Behind behind;
  std::vector<std::int32_t> room;
  for (std::int32_t m = 0; m < surface_.num_members(); ++m) {
    Near nearest{.owner = m, .distance = infinity};
    for (const std::int32_t s : surface_.search().near(m, c.x, c.margin, room)) {
      face(c, s, facing, nearest, behind);
    }
    if (nearest.distance == infinity) continue;
    facing.distance = std::min(facing.distance, nearest.distance);
    facing.near.push_back(nearest);
  }
  if (!behind.normal.isZero()) {
    facing.distance = 0;
    for (Near& near : facing.near) {
      if (near.owner == behind.owner) near.distance = 0;
    }
    if (surface_.num_members() > 1) face_next_members(c, behind, facing);
    drop_far_side(behind, facing);
  }
  return facing;
}

template <int dim>
void PointSearch<dim>::list_facing(Candidate& c) {
  if (c.is_listed) return;
  const Facing facing = facing_of(c);
  c.first_facing = static_cast<std::int32_t>(facing_.size());
  c.num_facing = static_cast<std::int32_t>(facing.simplices.size());
  c.distance = facing.distance;
  facing_.insert(facing_.end(), facing.simplices.begin(), facing.simplices.end());
  c.is_listed = true;
}

template <int dim>
void PointSearch<dim>::face(const Candidate& c, std::int32_t s, Facing& facing, Near& nearest,
                            Behind& behind) const {
  const SimplexBounds<dim>& bounds = surface_.search().bounds()[s];
  if (bounds.is_beyond(c.x, c.margin)) return;
  const auto corners = surface_.corners(s);
  const Vector<dim>& normal = bounds.normal;
  const double height = (c.x - corners[0]).dot(normal);
  const bool touched = going_on(c.memory, normal, nearest.owner) != nullptr;
  if (height <= 0 && !touched) return;
  const auto place = closest_place<dim>(corners, c.x);
  const double distance = (place.x - c.x).norm();
  facing.simplices.push_back({s, touched, height, distance});
  if (touched && distance < behind.distance) {
    behind = {.distance = distance, .height = height, .owner = nearest.owner};
    if (height <= 0) behind.normal = normal;
  }
  if (distance >= nearest.distance) return;
  nearest.distance = distance;
  nearest.place = {.simplex = s, .weights = place.weights, .x = place.x};
  nearest.place.normal = height > 0 ? Vector<dim>((c.x - place.x) / distance) : normal;
}

// A point behind a facet may come behind one of another member that meets it.
template <int dim>
void PointSearch<dim>::face_next_members(const Candidate& c, const Behind& behind,
                                         Facing& facing) const {
  const double farthest = std::min(c.margin, 2 * c.mean_radius());
  std::vector<std::int32_t> room;
  for (const std::int32_t s : surface_.search().near(c.x, farthest, room)) {
    const SimplexBounds<dim>& bounds = surface_.search().bounds()[s];
    if (bounds.is_beyond(c.x, farthest) || going_on(c.memory, bounds.normal, surface_.owner(s)))
      continue;
    const auto corners = surface_.corners(s);
    const double height = (c.x - corners[0]).dot(bounds.normal);
    if (height > 0 || bounds.normal.dot(behind.normal) <= same_normal) continue;
    const double distance = (closest_place<dim>(corners, c.x).x - c.x).norm();
    if (distance <= farthest) facing.simplices.push_back({s, true, height, distance});
  }
}

// Remove what the point no longer faces: facets of another member that lie behind the one that the
// point went through, with a structure between them.
template <int dim>
void PointSearch<dim>::drop_far_side(const Behind& behind, Facing& facing) const {
  std::erase_if(facing.simplices, [&](const FacingSimplex& simplex) {
    if (surface_.search().bounds()[simplex.simplex].normal.dot(behind.normal) >= -same_normal)
      return false;
    return surface_.owner(simplex.simplex) == behind.owner || simplex.height < -behind.height;
  });
}

template <int dim>
auto PointSearch<dim>::features_at_rest(Candidate& c, double distance) -> Features {
  list_facing(c);
  c.place = Place::other;
  find_features<dim>(view_of(c), c.x, c.x, {distance, c.mean_radius()}, features_);
  return features_;
}

template <int dim>
void PointSearch<dim>::refer_to_memory() {
  for (Candidate& c : candidates_) c.memory = memory_.contacts(c.id);
}

template <int dim>
FacingSurface<dim> PointSearch<dim>::view_of(const Candidate& c) const {
  return surface_.view(std::span(facing_).subspan(c.first_facing, c.num_facing),
                       seam_share * c.mean_radius());
}

template class PointSearch<2>;
template class PointSearch<3>;

}  // namespace gabion::mpm
