// SPDX-License-Identifier: BSD-3-Clause
// Contact by facets with soil that lies on surfaces when the run begins, with or without stress.
#include <algorithm>
#include <cmath>
#include <iterator>

#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/contact/facet_contact.hpp"

namespace gabion::mpm {

namespace {

// Number of projections that set a sphere off from faces at any angle; one is enough at right
// angles.
constexpr int projections = 20;

// Contact spheres that are off by less, by the cell size, touch.
constexpr double round_off = 1e-9;

}  // namespace

// Faces that soil was laid against where the point is. The force is that of the stress at the face,
// on the point's share of the side; the area of the contact may be another one.
template <int dim>
std::vector<RestingPlace<dim>> FacetContact<dim>::places_at_rest(Candidate& c,
                                                                 const SoilAtRest<dim>& rest) {
  std::vector<RestingPlace<dim>> places;
  const auto sides = rest.sides(c.body, c.id);
  if (sides.empty()) return places;
  double deepest = 0;
  for (const auto& side : sides) deepest = std::max(deepest, side.depth);
  const double tolerance = touching_share * cell_size_, reach = deepest + tolerance;
  const bool stressed = rest.is_stressed[c.body] != 0;
  // Soil that is free of stress may move fast: what is along its path does not matter here.
  c.margin = stressed ? std::max(c.margin, reach) : reach;
  for (const auto& feature : search_.features_at_rest(c, reach)) {
    const Vector<dim>& n = feature.normal;
    const auto side = std::find_if(sides.begin(), sides.end(), [&](const auto& s) {
      return s.normal.dot(n) > along_side && std::abs(s.depth - feature.distance) <= tolerance;
    });
    if (side == sides.end()) continue;
    Vector<dim> stress = Vector<dim>::Zero();
    if (stressed) stress = rest.stress(c.body, feature.x + side->shift);
    const Vector<dim> force = side->area * stress.cwiseProduct(n);
    const double R = c.radius(n), area = c.volume / (2 * R);
    const std::int32_t owner = surface_.owner(feature.simplex);
    const double penalty = law_of(c, owner, 1).penalty;
    const double square = -n.dot(force) / (area * penalty);
    if (stressed && !(square > 0)) continue;
    places.push_back({.normal = n,
                      .gap = feature.distance - R,
                      .square = square,
                      .pull = force - n.dot(force) * n,
                      .owner = owner});
  }
  return places;
}

// Sets the sphere off to where it touches.
template <int dim>
void FacetContact<dim>::set_off(std::span<const RestingPlace<dim>> places, Candidate& c) {
  Vector<dim> offset = Vector<dim>::Zero();
  for (int k = 0; k < projections; ++k) {
    for (const auto& place : places) {
      offset -= (place.gap + place.normal.dot(offset)) * place.normal;
    }
  }
  if (offset.norm() > round_off * cell_size_) {
    memory_.offsets()[c.id] = c.offset = offset;
    c.x += offset;
  }
}

// The contacts of a sphere that was set off begin with the depths of the stress.
template <int dim>
void FacetContact<dim>::remember_depths(std::span<const RestingPlace<dim>> places, Candidate& c) {
  auto& memory = memory_.add(c.id);
  memory.clear();
  std::vector<RestingPlace<dim>> together;
  for (const auto& place : places) {
    const Vector<dim>& n = place.normal;
    const double gap = place.gap + n.dot(c.offset);
    together.clear();
    std::ranges::copy_if(places, std::back_inserter(together), [&](const auto& other) {
      return place.owner == other.owner || n.dot(other.normal) >= corner_cosine;
    });
    Vector<dim> path = penetration_at_rest<dim>(together);
    const double quadratic = path.norm();
    const ContactLaw law = law_of(c, place.owner, 1);
    if (quadratic > law.linear_from) path *= law.depth_of(quadratic * quadratic) / quadratic;
    memory.emplace_back();
    memory.back().owner = place.owner;
    memory.back().normal = n;
    memory.back().slip = -(n.dot(path) + gap) * n;
  }
  c.memory = &memory;
}

template <int dim>
void FacetContact<dim>::remember_shear(const ContactPoint& contact,
                                       std::span<const RestingPlace<dim>> places) {
  const Candidate& c = candidate(contact);
  const double k = contact.area * law_of(c, contact.owner, contact.part).tangential_penalty;
  for (Remembered& memory : memory_.add(c.id)) {
    for (const auto& place : places) {
      if (memory.normal == place.normal && place.normal == contact.feature.normal) {
        memory.slip += place.pull / k;
        memory.part = contact.part;
      }
    }
  }
}

// The accepted state is that in which the contacts stand as they do.
template <int dim>
void FacetContact<dim>::remember_contacts(const SoilAtRest<dim>& rest) {
  memory_.take_contacts();
  for (Member& member : members_) {
    member.energy = {};
    member.stored_slip = 0;
  }
  for (const ContactPoint& contact : contacts_) {
    // Soil that is free of stress touches by rounding at most: its contact has not begun.
    if (!rest.is_stressed[candidate(contact).body]) continue;
    const Remembered memory = memory_of(contact);
    Member& member = members_[contact.owner];
    member.stored_slip += stored_in_slip(contact, memory);
    member.energy.stored += stored_in_depth(contact) + stored_in_slip(contact, memory);
    deepest_ = std::max(deepest_, -contact.gap);
    memory_.add(candidate(contact).id).push_back(memory);
  }
  deepest_ = max_over_ranks(comm_, deepest_);
  search_.refer_to_memory();
}

template <int dim>
void FacetContact<dim>::begin_at_rest(const SoilAtRest<dim>& rest) {
  const auto& soil = search_.soil();
  if (!soil) return;
  search_.complete_near(rest.deepest_row + touching_share * cell_size_);
  const std::vector<double> du(static_cast<std::size_t>(soil->nodes.size()) * dim, 0.0);
  std::vector<double> r(du.size());
  std::vector<std::vector<RestingPlace<dim>>> places;
  for (Candidate& c : search_.candidates()) {
    places.push_back(places_at_rest(c, rest));
    if (places.back().empty()) continue;
    set_off(places.back(), c);
    if (rest.is_stressed[c.body]) remember_depths(places.back(), c);
  }
  if (std::ranges::count(rest.is_stressed, 1) == 0) return;
  add_forces(du, r, nullptr);  // finds the parts of the tangential stiffness
  const auto has_shear = [](const Member& member) { return member.mode == ContactMode::contact; };
  if (std::ranges::any_of(members_, has_shear)) {
    for (const ContactPoint& contact : contacts_) {
      if (has_shear(members_[contact.owner])) remember_shear(contact, places[contact.candidate]);
    }
    add_forces(du, r, nullptr);
  }
  remember_contacts(rest);
}

template class FacetContact<2>;
template class FacetContact<3>;

}  // namespace gabion::mpm
