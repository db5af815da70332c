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

/// Of the soil of all ranks, once the largest values were found.
template <int dim>
struct Extent {
  static constexpr double none = -std::numeric_limits<double>::infinity();

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
  touches_.clear();
  substeps_.reset();
  may_touch_ = false;
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
  watched_ = watched_share * soil.cell_size + 2 * last_motion_;
  margin_ = watched_ + deepest_ + cube_side<dim>(all.widest);
  find_bounds();
  add_candidates(soil, FacetHash<dim>(simplices_, start_, margin_ + 2 * soil.dt * all.fastest,
                                      balls, {-all.minus_low, all.high}));
}

// A surface at rest keeps them.
template <int dim>
void FacetContact<dim>::find_bounds() {
  if (!bounds_.empty()) return;
  bounds_ = bounds_of<dim>(simplices_, start_);
  size_ = 0;
  for (const auto& bounds : bounds_) size_ = std::max(size_, 2 * bounds.radius);
}

template <int dim>
void FacetContact<dim>::add_candidates(const SoilSurface<dim>& soil, const FacetHash<dim>& hash) {
  for (const CellGroup& group : soil.weights.groups) {
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const std::int32_t p = soil.weights.point[e];
      const auto memory = memory_.find(soil.points.id[p]);
      const Vector<dim> offset = offset_of(soil.points.id[p]);
      const auto near = hash.near(soil.points.x[p] + offset);
      if (near.empty() && memory == memory_.end()) continue;
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
      if (soil.grid.basis != Basis::linear) {
        c.surface.emplace(soil.grid, soil.points, p);
      }
      add_values(soil, group, e);
      list_facing(
          c, near,
          margin_ + 2 * dt_ * fastest_about(soil.points, soil.weights, soil.nodes, group, e));
      const double speed = soil.points.v[p].norm() * soil.dt;
      const double reach =
          c.shape.norm() + c.offset.norm() + 2 * speed + 0.05 * soil.cell_size + 2 * last_motion_;
      may_touch_ |= c.memory || c.distance < reach;
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

// Only facets that a point is in front of can be touched by it: not those behind which it is, such
// as the far side of a thin structure. A point whose centre went through the side that it touched
// belongs to that side still.
template <int dim>
void FacetContact<dim>::list_facing(Candidate& c, std::span<const std::int32_t> near,
                                    double margin) {
  c.first_facing = static_cast<std::int32_t>(facing_.size());
  c.distance = std::numeric_limits<double>::infinity();
  double nearest_touched = c.distance;
  Vector<dim> through = Vector<dim>::Zero();  // normal of the touched facet that it is behind
  for (const std::int32_t s : near) {
    const SimplexBounds<dim>& bounds = bounds_[s];
    if (bounds.is_beyond(c.x, margin)) continue;
    const auto corners = corners_of<dim>(simplices_[s], start_);
    const Vector<dim>& normal = bounds.normal;
    const double height = (c.x - corners[0]).dot(normal);
    const bool touched = remembered(c, normal) != nullptr;
    if (height <= 0 && !touched) continue;
    const auto place = closest_place<dim>(corners, c.x);
    const double distance = (place.x - c.x).norm();
    facing_.push_back({s, touched, height, distance});
    if (touched && distance < nearest_touched) {
      nearest_touched = distance;
      through = height <= 0 ? normal : Vector<dim>(Vector<dim>::Zero());
    }
    if (distance >= c.distance) continue;
    c.distance = distance;
    c.nearest = {.simplex = s, .weights = place.weights, .x = place.x};
    c.nearest.normal = height > 0 ? Vector<dim>((c.x - place.x) / distance) : normal;
  }
  if (!through.isZero()) {
    c.distance = 0;
    drop_far_side(c, through);
  }
  c.num_facing = static_cast<std::int32_t>(facing_.size()) - c.first_facing;
}

template <int dim>
void FacetContact<dim>::drop_far_side(const Candidate& c, const Vector<dim>& normal) {
  const auto is_far = [&](const FacingSimplex& facing) {
    return bounds_[facing.simplex].normal.dot(normal) < -same_normal;
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
          .motion = surface_motion_,
          .size = size_};
}

template class FacetContact<2>;
template class FacetContact<3>;

}  // namespace gabion::mpm
