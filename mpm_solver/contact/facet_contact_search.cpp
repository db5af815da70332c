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

/// Of the soil of all ranks, once the largest values were found.
template <int dim>
struct Extent {
  static constexpr double none = -infinity;

  double fastest = 0;  // [m/s]
  double widest = 0;   // volume of a point [m^3]
  Vector<dim> minus_low = Vector<dim>::Constant(none), high = minus_low;

  std::span<double> values() {
    static_assert(sizeof(Extent) == (2 + 2 * dim) * sizeof(double));
    return {&fastest, 2 + 2 * std::size_t{dim}};
  }
};

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
  candidates_.clear();
  N_.clear();
  grad_N_.clear();
  nodes_.clear();
  facing_.clear();
  near_.clear();
  touches_.clear();
  order_touches();
  has_substeps_ = false;
  if (std::ranges::all_of(members_, &Member::dropped)) return;
  std::vector<Vector<dim>> balls;
  Extent<dim> all{.fastest =
                      std::max(largest_norm<dim>(soil.points.v), largest_norm<dim>(soil.nodes.v))};
  for (std::int32_t p = 0; p < soil.points.size(); ++p) {
    all.widest = std::max(all.widest, soil.points.V0[p] * soil.points.J[p]);
    balls.push_back(soil.points.x[p] + offset_of(soil.points.id[p]));
    all.minus_low = all.minus_low.cwiseMax(-balls.back());
    all.high = all.high.cwiseMax(balls.back());
  }
  max_over_ranks(comm_, all.values());
  double watched = 0;
  for (Member& member : members_) {
    member.may_touch = false;
    member.watched = watched_share * soil.cell_size + 2 * member.last_motion;
    watched = std::max(watched, member.watched);
  }
  margin_ = watched + deepest_ + cube_side<dim>(all.widest);
  find_bounds();
  std::vector<FacetHash<dim>> hashes;
  for (const Member& member : members_) {
    const std::size_t count = member.dropped ? 0 : static_cast<std::size_t>(member.num_simplices);
    hashes.emplace_back(std::span(simplices_).subspan(member.first_simplex, count), start_,
                        margin_ + 2 * soil.dt * all.fastest, balls,
                        typename FacetHash<dim>::Box{-all.minus_low, all.high});
  }
  add_candidates(soil, hashes);
}

// Members at rest keep them.
template <int dim>
void FacetContact<dim>::find_bounds() {
  bounds_.resize(simplices_.size());
  size_ = 0;
  for (Member& member : members_) {
    const auto own = std::span(bounds_).subspan(member.first_simplex, member.num_simplices);
    if (!member.bounds_known) {
      const auto found = bounds_of<dim>(
          std::span(simplices_).subspan(member.first_simplex, member.num_simplices), start_);
      std::copy(found.begin(), found.end(), own.begin());
      member.size = 0;
      for (const auto& bounds : own) member.size = std::max(member.size, 2 * bounds.radius);
      member.bounds_known = true;
    }
    size_ = std::max(size_, member.size);
  }
}

template <int dim>
void FacetContact<dim>::add_candidates(const SoilSurface<dim>& soil,
                                       std::span<const FacetHash<dim>> hashes) {
  near_lists_.resize(hashes.size());
  for (const CellGroup& group : soil.weights.groups) {
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const std::int32_t p = soil.weights.point[e];
      const auto memory = memory_.find(soil.points.id[p]);
      const Vector<dim> offset = offset_of(soil.points.id[p]);
      bool is_near = memory != memory_.end();
      for (std::size_t m = 0; m < hashes.size(); ++m) {
        near_lists_[m] = hashes[m].near(soil.points.x[p] + offset);
        is_near |= !near_lists_[m].empty();
      }
      if (!is_near) continue;
      Candidate& c = candidates_.emplace_back();
      c.id = soil.points.id[p];
      c.body = group.body;
      c.x = soil.points.x[p] + offset;
      c.offset = offset;
      c.deforms = soil.elastic[group.body] != 0;
      c.modulus = soil.moduli[group.body];
      c.volume = soil.points.V0[p] * (c.deforms ? soil.points.J[p] : 1);
      c.shape = shape_of(c.id, soil.points.depth[p]);
      if (memory != memory_.end()) c.memory = &memory->second;
      c.took_weight = c.memory ? c.memory->front().took_weight : soil.takes_weight;
      if (c.took_weight) c.weight = soil.weights_of[group.body];
      if (soil.grid.basis != Basis::linear) {
        c.surface.emplace(soil.grid, soil.points, p);
      }
      add_values(soil, group, e);
      list_facing(
          c, margin_ + 2 * dt_ * fastest_about(soil.points, soil.weights, soil.nodes, group, e));
      const double speed = soil.points.v[p].norm() * soil.dt;
      mark_touching(c, c.shape.norm() + c.offset.norm() + 2 * speed + 0.05 * soil.cell_size);
    }
  }
}

// Basis functions of the candidate added last.
template <int dim>
void FacetContact<dim>::add_values(const SoilSurface<dim>& soil, const CellGroup& group,
                                   std::int32_t entry) {
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

// @param reach  of the point, towards members at rest [m]
template <int dim>
void FacetContact<dim>::mark_touching(const Candidate& c, double reach) {
  if (c.memory) {
    for (const Memory& memory : *c.memory) members_[memory.owner].may_touch = true;
  }
  for (std::int32_t k = c.first_near; k < c.first_near + c.num_near; ++k) {
    Member& member = members_[near_[k].owner];
    member.may_touch |= near_[k].distance < reach + 2 * member.last_motion;
  }
}

// Only facets that a point is in front of can be touched by it: not those behind which it is, such
// as the far side of a thin structure. A point whose centre went through the side that it touched
// belongs to that side still.
template <int dim>
void FacetContact<dim>::list_facing(Candidate& c, double margin) {
  c.first_facing = static_cast<std::int32_t>(facing_.size());
  c.first_near = static_cast<std::int32_t>(near_.size());
  c.distance = infinity;
  Behind behind;
  for (std::size_t m = 0; m < members_.size(); ++m) {
    const std::int32_t first = members_[m].first_simplex;
    Near nearest{.owner = static_cast<std::int32_t>(m), .distance = infinity};
    for (const std::int32_t s : near_lists_[m]) face(c, first + s, margin, nearest, behind);
    if (nearest.distance == infinity) continue;
    c.distance = std::min(c.distance, nearest.distance);
    near_.push_back(nearest);
  }
  c.num_near = static_cast<std::int32_t>(near_.size()) - c.first_near;
  if (!behind.normal.isZero()) {
    c.distance = 0;
    for (std::int32_t k = c.first_near; k < c.first_near + c.num_near; ++k) {
      if (near_[k].owner == behind.owner) near_[k].distance = 0;
    }
    if (members_.size() > 1) face_next_members(c, margin, behind);
    drop_far_side(c, behind);
  }
  c.num_facing = static_cast<std::int32_t>(facing_.size()) - c.first_facing;
}

template <int dim>
void FacetContact<dim>::face(const Candidate& c, std::int32_t s, double margin, Near& nearest,
                             Behind& behind) {
  const SimplexBounds<dim>& bounds = bounds_[s];
  if (bounds.is_beyond(c.x, margin)) return;
  const auto corners = corners_of<dim>(simplices_[s], start_);
  const Vector<dim>& normal = bounds.normal;
  const double height = (c.x - corners[0]).dot(normal);
  const bool touched = remembered(c, normal, nearest.owner) != nullptr;
  if (height <= 0 && !touched) return;
  const auto place = closest_place<dim>(corners, c.x);
  const double distance = (place.x - c.x).norm();
  facing_.push_back({s, touched, height, distance});
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
void FacetContact<dim>::face_next_members(const Candidate& c, double margin, const Behind& behind) {
  const double farthest = std::min(margin, 2 * mean_radius(c));
  for (std::size_t m = 0; m < members_.size(); ++m) {
    for (const std::int32_t k : near_lists_[m]) {
      const std::int32_t s = members_[m].first_simplex + k;
      if (bounds_[s].is_beyond(c.x, farthest) || remembered(c, bounds_[s].normal, owner_[s])) {
        continue;
      }
      const auto corners = corners_of<dim>(simplices_[s], start_);
      const double height = (c.x - corners[0]).dot(bounds_[s].normal);
      if (height > 0 || bounds_[s].normal.dot(behind.normal) <= same_normal) continue;
      const double distance = (closest_place<dim>(corners, c.x).x - c.x).norm();
      if (distance <= farthest) facing_.push_back({s, true, height, distance});
    }
  }
}

// Of another member only what lies behind the one that the point went through, with a structure
// between them; not what it faces.
template <int dim>
void FacetContact<dim>::drop_far_side(const Candidate& c, const Behind& behind) {
  const auto is_far = [&](const FacingSimplex& facing) {
    if (bounds_[facing.simplex].normal.dot(behind.normal) >= -same_normal) return false;
    return owner_[facing.simplex] == behind.owner || facing.height < -behind.height;
  };
  facing_.erase(std::remove_if(facing_.begin() + c.first_facing, facing_.end(), is_far),
                facing_.end());
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
          .size = size_,
          .seam = seam_share * mean_radius(c)};
}

template class FacetContact<2>;
template class FacetContact<3>;

}  // namespace gabion::mpm
