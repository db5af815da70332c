// SPDX-License-Identifier: BSD-3-Clause
// The accepted state of a contact by facets.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/contact/facet_contact.hpp"

namespace gabion::mpm {

template <int dim>
ContactMark<dim> FacetContact<dim>::mark_of(const ContactPoint& contact) const {
  const Vector<dim>& n = contact.feature.normal;
  const auto& member = surface_.member(contact.owner);
  const int cuts = member.surface.facet_type == CellType::quad4 ? 2 : 1;
  return {.facet = (contact.feature.simplex - member.first_simplex) / cuts,
          .sliding = contact.traction.sliding,
          .area = contact.area,
          .gap = contact.gap + contact.initial_penetration,
          .x = contact.feature.x,
          .normal = n,
          .force = -contact.force,
          .slip = (contact.relative - n.dot(contact.relative) * n) / dt_};
}

template <int dim>
ContactFields<dim> FacetContact<dim>::fields(const MaterialPoints<dim>& points, double reach,
                                             std::size_t member) const {
  const auto& own = surface_.member(member);
  const auto vertices = surface_.start_of(member);
  ContactFields<dim> fields({vertices.begin(), vertices.end()},
                            own.surface.facets.size() / num_nodes(own.surface.facet_type));
  if (own.dropped) return fields;
  spread_marks<dim>(own.surface, members_[member].marks, fields);
  const auto sphere_of = [&](std::int32_t p) -> ContactSphere<dim> {
    const std::int64_t id = points.id[p];
    return {memory_.shape(id, points.depth[p]), memory_.offset(id)};
  };
  add_gaps<dim>(own.surface, points, sphere_of, reach, fields);
  return fields;
}

// The deepest contact of a sphere comes last: it holds where normals are not at right angles.
template <int dim>
void FacetContact<dim>::accept_offsets() {
  search_.find_opened([this](std::int32_t k, std::span<const SurfaceFeature<dim>> features) {
    const Candidate& c = search_.candidates()[k];
    for (const auto& feature : features) {
      ContactPoint contact = contact_at(c, feature, search_.du());
      contact.candidate = k;
      if (contact.gap >= 0) opened_.push_back(contact);
    }
  });
  std::vector<const ContactPoint*> order;
  for (const auto* contacts : {&contacts_, &opened_}) {
    for (const ContactPoint& contact : *contacts) order.push_back(&contact);
  }
  std::stable_sort(order.begin(), order.end(),
                   [](const ContactPoint* a, const ContactPoint* b) { return a->gap > b->gap; });
  auto& offsets = memory_.offsets();
  offsets.clear();
  for (const ContactPoint* contact : order) {
    const Candidate& c = candidate(*contact);
    const Vector<dim>& n = contact->feature.normal;
    Vector<dim>& offset = offsets.try_emplace(c.id, c.offset).first->second;
    offset += (offset_after(*contact) - offset.dot(n)) * n;
  }
  std::erase_if(offsets, [](const auto& entry) { return entry.second.isZero(0); });
}

template <int dim>
typename FacetContact<dim>::Remembered FacetContact<dim>::memory_of(
    const ContactPoint& contact) const {
  const Vector<dim>& n = contact.feature.normal;
  Remembered memory{.owner = contact.owner,
                    .normal = n,
                    .force = contact.force,
                    .slip = -contact.initial_penetration * n,
                    .part = contact.part,
                    .lasting = lasting_force(contact),
                    .took_weight = candidate(contact).took_weight};
  const ContactLaw law = law_of(candidate(contact), contact.owner, contact.part);
  if (law.mode == ContactMode::contact) {
    const Vector<dim> pull = contact.force - n.dot(contact.force) * n;
    memory.slip -= pull / (contact.area * law.tangential_penalty);
  }
  return memory;
}

template <int dim>
double FacetContact<dim>::stored_in_slip(const ContactPoint& contact,
                                         const Remembered& memory) const {
  const Candidate& c = candidate(contact);
  const double k = law_of(c, contact.owner, contact.part).tangential_penalty;
  return 0.5 * contact.area * k * memory.tangential().squaredNorm();
}

template <int dim>
double FacetContact<dim>::stored_in_depth(const ContactPoint& contact) const {
  const ContactLaw law = law_of(candidate(contact), contact.owner, 1);
  return contact.area * law.stored(contact.stored_depth);
}

template <int dim>
void FacetContact<dim>::accept_contacts(std::size_t owner) {
  Member& member = members_[owner];
  double work = 0, stored = 0, stored_slip = 0, slid = 0;
  member.marks.clear();
  for (const std::int32_t k : contacts_of(owner)) {
    const ContactPoint& contact = contacts_[k];
    deepest_ = std::max(deepest_, -contact.gap);
    member.marks.push_back(mark_of(contact));
    const Remembered memory = memory_of(contact);
    if (member.mode == ContactMode::contact) {
      const Vector<dim>& n = contact.feature.normal;
      const Vector<dim> pull = contact.force - n.dot(contact.force) * n;
      slid -= pull.dot(contact.slip - memory.tangential());
    }
    stored_slip += stored_in_slip(contact, memory);
    stored += stored_in_depth(contact) + stored_in_slip(contact, memory);
    work -= contact.force.dot(contact.relative);
    memory_.add(candidate(contact).id).push_back(memory);
  }
  if (has_substeps_) {
    const Substeps& sums = member.substeps;
    work = sums.normal_work + sums.tangential_work;
    slid = sums.tangential_work - (stored_slip - member.stored_slip);
  }
  member.energy.add_step(work, stored, slid);
  member.stored_slip = stored_slip;
}

template <int dim>
void FacetContact<dim>::accept() {
  const auto before = memory_.take_contacts();  // candidates refer to them
  deepest_ = 0;
  for (std::size_t owner = 0; owner < members_.size(); ++owner) accept_contacts(owner);
  deepest_ = max_over_ranks(comm_, deepest_);
  accept_offsets();
  auto& shapes = memory_.shapes();
  shapes.clear();
  for (const Candidate& c : search_.candidates()) {
    if (c.deforms) shapes[c.id] = c.shape * (Matrix<dim>::Identity() + c.H).transpose();
  }
  surface_.accept();
  search_.end_step();
  contacts_.clear();
  opened_.clear();
  order_contacts();
}

// What is remembered of the contacts of all candidates, at the place where they are as the step
// starts.
template <int dim>
void FacetContact<dim>::add_remembered(std::int32_t owner, Vector<dim> Remembered::*force,
                                       double share, std::span<double> field) const {
  std::vector<double> w;
  for (const Candidate& c : search_.candidates()) {
    if (!c.memory) continue;
    w.resize(c.num_values);
    for (const Remembered& memory : *c.memory) {
      if (memory.owner != owner) continue;
      search_.surface_weights(c, memory.normal, w.data());
      search_.scatter(c, w.data(), share * memory.*force, field);
    }
  }
}

template <int dim>
void FacetContact<dim>::add_old_forces(std::int32_t owner, double share,
                                       std::span<double> field) const {
  add_remembered(owner, &Remembered::force, share, field);
}

template <int dim>
void FacetContact<dim>::visit_state(StateVisitor& visitor, const std::string& prefix) {
  surface_.visit_vertices(visitor, prefix);
  visitor.real(prefix + "deepest", deepest_);
  memory_.visit_state(visitor, prefix, members_.size());
  for (std::size_t m = 0; m < members_.size(); ++m) {
    Member& member = members_[m];
    const std::string own = fmt::format("{}member_{}.", prefix, m);
    surface_.visit_member(m, visitor, own);
    const auto& surface = surface_.member(m).surface;
    visit_marks<dim>(visitor, own, surface.facets.size() / num_nodes(surface.facet_type),
                     member.marks);
    const std::pair<const char*, double*> energies[] = {{"stored", &member.energy.stored},
                                                        {"friction", &member.energy.friction},
                                                        {"loss", &member.energy.loss},
                                                        {"stored_slip", &member.stored_slip}};
    for (const auto& [name, value] : energies) visitor.share(own + name, *value);
  }
}

template class FacetContact<2>;
template class FacetContact<3>;

}  // namespace gabion::mpm
