// SPDX-License-Identifier: BSD-3-Clause
// What a contact by facets may touch in a step.
#include <algorithm>
#include <cmath>
#include <limits>

#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/contact/facet_contact.hpp"
#include "mpm_solver/grid/fastest_about.hpp"

namespace gabion::mpm {

namespace {

// Soil and surface may come nearer by this share of a cell, beyond what their speeds say, before a
// step is refused that did not look so far.
constexpr double watched_share = 0.5;

// Rims that are nearer to a surface than this share of a ball's radius meet it.
constexpr double seam_share = 1e-3;

constexpr double infinity = std::numeric_limits<double>::infinity();

// What is nearer than a limit to within this share of it may be beyond it by rounding.
constexpr double rounding = 1e-9;

template <int dim>
double largest_norm(const std::vector<Vector<dim>>& values) {
  double largest = 0;
  for (const auto& v : values) largest = std::max(largest, v.norm());
  return largest;
}

}  // namespace

template <int dim>
void FacetContact<dim>::begin_step(const SoilSurface<dim>& soil) {
  force_weight_ = soil.step_force_weight;
  cell_size_ = soil.cell_size;
  dt_ = soil.dt;
  comm_ = soil.comm;
  soil_.emplace(soil);
  watched_.clear();
  watched_groups_.clear();
  candidates_.clear();
  N_.clear();
  grad_N_.clear();
  nodes_.clear();
  facing_.clear();
  du_.clear();
  touches_.clear();
  order_touches();
  has_substeps_ = false;
  if (std::ranges::all_of(members_, &Member::dropped)) return;
  double all[] = {std::max(largest_norm<dim>(soil.points.v), largest_norm<dim>(soil.nodes.v)), 0};
  for (std::int32_t p = 0; p < soil.points.size(); ++p) {
    all[1] = std::max(all[1], soil.points.V0[p] * soil.points.J[p]);
  }
  max_over_ranks(comm_, std::span<double>(all));
  const auto [fastest, widest] = all;
  double watched = 0;
  for (Member& member : members_) {
    member.may_touch = false;
    member.watched = watched_share * soil.cell_size + 2 * member.last_motion;
    watched = std::max(watched, member.watched);
  }
  margin_ = watched + deepest_ + cube_side<dim>(widest);
  search_.begin_step(simplices_, start_, cube_side<dim>(widest));
  watch_points(margin_ + 2 * soil.dt * fastest);
}

// @param margin  what is farther from any point cannot be touched [m]
template <int dim>
void FacetContact<dim>::watch_points(double margin) {
  list_remembered();
  const SoilSurface<dim>& soil = *soil_;
  const auto& groups = soil.weights.groups;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const CellGroup& group = groups[g];
    const auto first = static_cast<std::int32_t>(watched_.size());
    for (std::int32_t e = group.first; e < group.last; ++e) {
      Watched point = watched(e);
      const bool deforms = soil.elastic[group.body] != 0;
      if (deforms && !point.memory && !is_near(point.x, margin)) continue;
      if (deforms || point.memory) complete(point, group);
      mark_touching(point, group);
      watched_.push_back(point);
    }
    add_group(static_cast<std::int32_t>(g), first);
  }
}

// @param first  of its points, which were watched last
template <int dim>
void FacetContact<dim>::add_group(std::int32_t group, std::int32_t first) {
  const auto last = static_cast<std::int32_t>(watched_.size());
  if (last == first) return;
  WatchedGroup result{.group = group, .first = first, .last = last};
  Vector<dim> low = Vector<dim>::Constant(infinity), high = -low;
  for (std::int32_t k = first; k < last; ++k) {
    const Watched& point = watched_[k];
    low = low.cwiseMin(point.x);
    high = high.cwiseMax(point.x);
    result.reach = std::max(result.reach, point.candidate < 0 ? point.reach : infinity);
  }
  if (result.reach < infinity) {
    result.clearance = search_.far_at_least(0.5 * (low + high), 0.5 * (high - low));
  }
  watched_groups_.push_back(result);
}

// Finds what is remembered of a point by its id.
template <int dim>
void FacetContact<dim>::list_remembered() {
  remembered_.clear();
  memory_of_.clear();
  offset_of_.clear();
  const auto number = [this](std::int64_t id) {
    const auto k = static_cast<std::size_t>(remembered_.add({id}));
    memory_of_.resize(static_cast<std::size_t>(remembered_.size()));
    offset_of_.resize(memory_of_.size());
    return k;
  };
  for (const auto& [id, memory] : memory_) memory_of_[number(id)] = &memory;
  for (const auto& [id, offset] : offset_) offset_of_[number(id)] = &offset;
}

template <int dim>
typename FacetContact<dim>::Watched FacetContact<dim>::watched(std::int32_t entry) const {
  const SoilSurface<dim>& soil = *soil_;
  const std::int32_t p = soil.weights.point[entry];
  Watched point{.entry = entry, .x = soil.points.x[p]};
  const std::int32_t known = remembered_.find({soil.points.id[p]});
  if (known >= 0) {
    point.memory = memory_of_[known];
    point.offset = offset_of_[known];
  }
  double offset = 0;
  if (point.offset) {
    point.x += *point.offset;
    offset = point.offset->norm();
  }
  point.reach = soil.points.depth[p] * std::sqrt(double{dim}) + offset;
  return point;
}

template <int dim>
bool FacetContact<dim>::is_near(const Vector<dim>& x, double margin) {
  const auto near = search_.near(x, margin, near_);
  return std::ranges::any_of(
      near, [&](std::int32_t s) { return !search_.bounds()[s].is_beyond(x, margin); });
}

// A candidate without its basis functions.
template <int dim>
typename FacetContact<dim>::Candidate FacetContact<dim>::candidate_of(
    const Watched& point, const CellGroup& group) const {
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
  c.shape = shape_of(c.id, soil.points.depth[p]);
  c.memory = point.memory;
  c.took_weight = c.memory ? c.memory->front().took_weight : soil.takes_weight;
  if (c.took_weight) c.weight = soil.weights_of[group.body];
  c.reaches_far = c.deforms || soil.grid.basis == Basis::bspline;
  c.margin =
      margin_ + 2 * dt_ * fastest_about(soil.points, soil.weights, soil.nodes, group, point.entry);
  return c;
}

template <int dim>
typename FacetContact<dim>::Candidate& FacetContact<dim>::complete(Watched& point,
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
void FacetContact<dim>::add_values(const CellGroup& group, std::int32_t entry) {
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

// Members that the point may touch in the step, by its speed as it begins.
template <int dim>
void FacetContact<dim>::mark_touching(const Watched& point, const CellGroup& group) {
  if (point.memory) {
    for (const Memory& memory : *point.memory) members_[memory.owner].may_touch = true;
  }
  const SoilSurface<dim>& soil = *soil_;
  const double speed = soil.points.v[soil.weights.point[point.entry]].norm() * soil.dt;
  std::optional<Facing> facing;
  for (std::size_t m = 0; m < members_.size(); ++m) {
    Member& member = members_[m];
    if (member.may_touch || member.dropped) continue;
    const auto reach = [&](double ball) {
      return ball + 2 * speed + 0.05 * soil.cell_size + 2 * member.last_motion;
    };
    const double nearest = search_.at_least(m, point.x, Vector<dim>::Zero());
    if (!point.memory && !soil.elastic[group.body] &&
        nearest > (1 + rounding) * reach(point.reach)) {
      continue;
    }
    const Candidate c = candidate_of(point, group);
    if (!facing) facing = facing_of(c);
    for (const Near& near : facing->near) {
      if (near.owner != static_cast<std::int32_t>(m)) continue;
      member.may_touch |= near.distance < reach(c.shape.norm() + c.offset.norm());
    }
  }
}

template <int dim>
void FacetContact<dim>::complete_all() {
  for (WatchedGroup& watched : watched_groups_) {
    const CellGroup& group = soil_->weights.groups[watched.group];
    for (std::int32_t k = watched.first; k < watched.last; ++k) complete(watched_[k], group);
    watched.reach = infinity;
  }
}

// Only facets that a point is in front of can be touched by it: not those behind which it is, such
// as the far side of a thin structure. A point whose centre went through the side that it touched
// belongs to that side still.
template <int dim>
typename FacetContact<dim>::Facing FacetContact<dim>::facing_of(const Candidate& c) const {
  Facing facing;
  facing.distance = infinity;
  Behind behind;
  std::vector<std::int32_t> room;
  for (std::size_t m = 0; m < members_.size(); ++m) {
    Near nearest{.owner = static_cast<std::int32_t>(m), .distance = infinity};
    for (const std::int32_t s : search_.near(m, c.x, c.margin, room)) {
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
    if (members_.size() > 1) face_next_members(c, behind, facing);
    drop_far_side(behind, facing);
  }
  return facing;
}

template <int dim>
void FacetContact<dim>::list_facing(Candidate& c) {
  if (c.is_listed) return;
  const Facing facing = facing_of(c);
  c.first_facing = static_cast<std::int32_t>(facing_.size());
  c.num_facing = static_cast<std::int32_t>(facing.simplices.size());
  c.distance = facing.distance;
  facing_.insert(facing_.end(), facing.simplices.begin(), facing.simplices.end());
  c.is_listed = true;
}

template <int dim>
void FacetContact<dim>::face(const Candidate& c, std::int32_t s, Facing& facing, Near& nearest,
                             Behind& behind) const {
  const SimplexBounds<dim>& bounds = search_.bounds()[s];
  if (bounds.is_beyond(c.x, c.margin)) return;
  const auto corners = corners_of<dim>(simplices_[s], start_);
  const Vector<dim>& normal = bounds.normal;
  const double height = (c.x - corners[0]).dot(normal);
  const bool touched = remembered(c, normal, nearest.owner) != nullptr;
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
void FacetContact<dim>::face_next_members(const Candidate& c, const Behind& behind,
                                          Facing& facing) const {
  const double farthest = std::min(c.margin, 2 * mean_radius(c));
  std::vector<std::int32_t> room;
  for (const std::int32_t s : search_.near(c.x, farthest, room)) {
    const SimplexBounds<dim>& bounds = search_.bounds()[s];
    if (bounds.is_beyond(c.x, farthest) || remembered(c, bounds.normal, owner_[s])) continue;
    const auto corners = corners_of<dim>(simplices_[s], start_);
    const double height = (c.x - corners[0]).dot(bounds.normal);
    if (height > 0 || bounds.normal.dot(behind.normal) <= same_normal) continue;
    const double distance = (closest_place<dim>(corners, c.x).x - c.x).norm();
    if (distance <= farthest) facing.simplices.push_back({s, true, height, distance});
  }
}

// The point no longer faces what belongs to another member and lies behind the one that the point
// went through, with a structure between them.
template <int dim>
void FacetContact<dim>::drop_far_side(const Behind& behind, Facing& facing) const {
  std::erase_if(facing.simplices, [&](const FacingSimplex& simplex) {
    if (search_.bounds()[simplex.simplex].normal.dot(behind.normal) >= -same_normal) return false;
    return owner_[simplex.simplex] == behind.owner || simplex.height < -behind.height;
  });
}

template <int dim>
FacingSurface<dim> FacetContact<dim>::surface_of(const Candidate& c,
                                                 std::span<const Vector<dim>> end) const {
  return {.simplices = simplices_,
          .start = start_,
          .end = end,
          .facing = std::span(facing_).subspan(c.first_facing, c.num_facing),
          .rim = rim_,
          .owner = members_.size() > 1 ? std::span<const std::int32_t>(owner_)
                                       : std::span<const std::int32_t>(),
          .motion = surface_motion_,
          .size = search_.size(),
          .seam = seam_share * mean_radius(c)};
}

template class FacetContact<2>;
template class FacetContact<3>;

}  // namespace gabion::mpm
