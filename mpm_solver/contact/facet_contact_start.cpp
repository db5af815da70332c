// SPDX-License-Identifier: BSD-3-Clause
// Contact by facets with soil that is at rest under stress when the run begins.
#include <algorithm>
#include <cmath>

#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/contact/facet_contact.hpp"
#include "mpm_solver/contact/way_at_rest.hpp"

namespace gabion::mpm {

namespace {

template <int dim>
Vector<dim> shear(const Vector<dim>& stress, const Vector<dim>& n) {
  const Vector<dim> traction = stress.cwiseProduct(n);
  return traction - n.dot(traction) * n;
}

template <int dim>
double pressure(const Vector<dim>& stress, const Vector<dim>& n) {
  return -n.dot(stress.cwiseProduct(n));
}

}  // namespace

// What a point will remember of the places where it rests on the surface, without friction. Its
// area is that of the unstressed volume where it does not deform: the traction is less by as much.
template <int dim>
std::vector<typename FacetContact<dim>::Memory> FacetContact<dim>::touches_at_rest(
    std::int32_t candidate, std::span<const double> du, const StressAtRest<dim>& stress) {
  const Candidate& c = candidates_[candidate];
  const double tolerance = touching_share * cell_size_;
  find_features<dim>(surface_of(c, end_), c.x, c.x, c.shape.norm() + tolerance, features_);
  const double share = c.present / law_of(c, 1).penalty;
  std::vector<RestingPlace<dim>> places;
  for (const auto& feature : features_) {
    const Touch touch = touch_at(c, feature, du);
    const auto at_place = stress(c.body, feature.x);
    if (!at_place || std::abs(touch.gap) > tolerance) continue;
    const double square = share * pressure<dim>(*at_place, feature.normal);
    if (square > 0) places.push_back({feature.normal, touch.gap, square});
  }
  const Vector<dim> way = way_at_rest<dim>(places);
  std::vector<Memory> memories;
  for (const auto& [n, gap, square] : places) {
    Memory& memory = memories.emplace_back();
    memory.normal = n;
    memory.slip = -(n.dot(way) + gap) * n;
  }
  return memories;
}

template <int dim>
void FacetContact<dim>::remember_shear(const Touch& touch, const StressAtRest<dim>& stress) {
  const Candidate& c = candidates_[touch.candidate];
  const auto at_place = stress(c.body, touch.feature.x);
  if (!at_place) return;
  const Vector<dim>& n = touch.feature.normal;
  for (Memory& memory : memory_[c.id]) {
    if (memory.normal != n) continue;
    memory.slip += c.present / law_of(c, touch.part).tangential_penalty * shear<dim>(*at_place, n);
  }
}

// Of the accepted state, that touches stand as they do.
template <int dim>
void FacetContact<dim>::remember_touches() {
  memory_.clear();
  energy_ = {};
  stored_slip_ = 0;
  for (const Touch& touch : touches_) {
    const Memory memory = memory_of(touch);
    stored_slip_ += stored_in_slip(touch, memory);
    energy_.stored += stored_in_depth(touch) + stored_in_slip(touch, memory);
    deepest_ = std::max(deepest_, -touch.gap);
    memory_[candidates_[touch.candidate].id].push_back(memory);
  }
  deepest_ = max_over_ranks(comm_, deepest_);
  for (Candidate& c : candidates_) {
    const auto memory = memory_.find(c.id);
    c.memory = memory == memory_.end() ? nullptr : &memory->second;
  }
}

template <int dim>
void FacetContact<dim>::begin_at_rest(const StressAtRest<dim>& stress) {
  const std::int32_t nodes =
      nodes_.empty() ? 0 : 1 + *std::max_element(nodes_.begin(), nodes_.end());
  const std::vector<double> du(static_cast<std::size_t>(nodes) * dim, 0.0);
  std::vector<double> r(du.size());
  for (std::size_t k = 0; k < candidates_.size(); ++k) {
    auto touches = touches_at_rest(static_cast<std::int32_t>(k), du, stress);
    if (touches.empty()) continue;
    auto& memory = memory_[candidates_[k].id];
    memory = std::move(touches);
    candidates_[k].memory = &memory;
  }
  add_forces(du, r, nullptr);  // finds the parts of the tangential stiffness
  if (mode_ == ContactMode::contact) {
    for (const Touch& touch : touches_) remember_shear(touch, stress);
    add_forces(du, r, nullptr);
  }
  remember_touches();
}

template class FacetContact<2>;
template class FacetContact<3>;

}  // namespace gabion::mpm
