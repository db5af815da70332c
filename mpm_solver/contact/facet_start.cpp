// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/facet_start.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace gabion::mpm {

namespace {

// Number of projections that set a sphere off from faces at any angle; one is enough at right
// angles.
constexpr int projections = 20;

// Contact spheres whose distance is below this share of the cell size are in contact.
constexpr double round_off = 1e-9;

/// Soil that was laid at a side nearer to the surface than this share of a cell rests on it,
constexpr double touching_share = 0.01;
/// where the side is turned against the surface by no more than the angle of this cosine.
constexpr double along_side = 0.99;

}  // namespace

// Faces that soil was laid against where the point is. The force is that of the stress at the face,
// on the point's share of the side; the area of the contact may be another one.
template <int dim>
std::vector<RestingPlace<dim>> FacetStart<dim>::places_at_rest(Candidate& c,
                                                               const SoilAtRest<dim>& rest) {
  std::vector<RestingPlace<dim>> places;
  const auto sides = rest.sides(c.body, c.id);
  if (sides.empty()) return places;
  double deepest = 0;
  for (const auto& side : sides) deepest = std::max(deepest, side.depth);
  const double tolerance = touching_share * parts_.laws.cell_size(), reach = deepest + tolerance;
  const bool stressed = rest.is_stressed[c.body] != 0;
  // Soil that is free of stress may move fast: surfaces along its path do not matter here.
  c.margin = stressed ? std::max(c.margin, reach) : reach;
  for (const auto& feature : parts_.search.features_at_rest(c, reach)) {
    const Vector<dim>& n = feature.normal;
    const auto side = std::find_if(sides.begin(), sides.end(), [&](const auto& s) {
      return s.normal.dot(n) > along_side && std::abs(s.depth - feature.distance) <= tolerance;
    });
    if (side == sides.end()) continue;
    Vector<dim> stress = Vector<dim>::Zero();
    if (stressed) stress = rest.stress(c.body, feature.x + side->shift);
    const Vector<dim> force = side->area * stress.cwiseProduct(n);
    const double R = c.radius(n), area = c.volume / (2 * R);
    const std::int32_t owner = parts_.surface.owner(feature.simplex);
    const double penalty = parts_.laws.law_of(c, owner, 1).penalty;
    places.push_back({.normal = n,
                      .gap = feature.distance - R,
                      .square = -n.dot(force) / (area * penalty),
                      .pull = force - n.dot(force) * n,
                      .owner = owner});
  }
  return places;
}

// Set the sphere off until it is in contact.
template <int dim>
void FacetStart<dim>::set_off(Places places, Candidate& c) {
  Vector<dim> offset = Vector<dim>::Zero();
  for (int k = 0; k < projections; ++k) {
    for (const auto& place : places) {
      offset -= (place.gap + place.normal.dot(offset)) * place.normal;
    }
  }
  if (offset.norm() > round_off * parts_.laws.cell_size()) {
    parts_.memory.offsets()[c.id] = parts_.memory.laid_offsets()[c.id] = c.offset = offset;
    c.x += offset;
  }
}

// The contacts of a sphere that was set off begin with the depths of the stress.
template <int dim>
void FacetStart<dim>::remember_depths(Places places, Candidate& c) {
  auto& memory = parts_.memory.add(c.id);
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
    const ContactLaw law = parts_.laws.law_of(c, place.owner, 1);
    if (quadratic > law.linear_from) path *= law.depth_of(quadratic * quadratic) / quadratic;
    memory.emplace_back();
    memory.back().owner = place.owner;
    memory.back().normal = n;
    memory.back().slip = -(n.dot(path) + gap) * n;
  }
  c.memory = &memory;
}

template <int dim>
void FacetStart<dim>::remember_shear(const ContactPoint<dim>& contact, Places places) {
  const Candidate& c = parts_.points.candidate(contact);
  const double k = contact.area * parts_.points.law_of(contact, contact.part).tangential_penalty;
  for (RememberedContact<dim>& memory : parts_.memory.add(c.id)) {
    for (const auto& place : places) {
      if (memory.normal == place.normal && place.normal == contact.feature.normal) {
        memory.slip += place.pull / k;
        memory.part = contact.part;
      }
    }
  }
}

template <int dim>
bool FacetStart<dim>::begin(const SoilAtRest<dim>& rest) {
  const auto& soil = parts_.search.soil();
  if (!soil) return false;
  parts_.search.complete_near(rest.deepest_row + touching_share * parts_.laws.cell_size());
  const std::vector<double> du(static_cast<std::size_t>(soil->nodes.size()) * dim, 0.0);
  std::vector<double> r(du.size());
  std::vector<std::vector<RestingPlace<dim>>> places;
  for (Candidate& c : parts_.search.candidates()) {
    places.push_back(places_at_rest(c, rest));
    if (places.back().empty()) continue;
    set_off(places.back(), c);
    // Faces that nothing presses on are touched, no more.
    std::erase_if(places.back(), [](const auto& place) { return !(place.square > 0); });
    if (!places.back().empty()) remember_depths(places.back(), c);
  }
  if (std::ranges::count(rest.is_stressed, 1) == 0) return false;
  assembly_.add_forces(du, r, nullptr);  // finds the parts of the tangential stiffness
  const auto has_shear = [&](std::int32_t member) {
    return parts_.laws.mode(member) == ContactMode::contact;
  };
  bool any_has_shear = false;
  for (std::int32_t m = 0; m < parts_.surface.num_members(); ++m) any_has_shear |= has_shear(m);
  if (any_has_shear) {
    for (const ContactPoint<dim>& contact : parts_.points.all()) {
      if (has_shear(contact.owner)) remember_shear(contact, places[contact.candidate]);
    }
    assembly_.add_forces(du, r, nullptr);
  }
  return true;
}

template class FacetStart<2>;
template class FacetStart<3>;

}  // namespace gabion::mpm
