// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/facet_state.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "common/base/require.hpp"
#include "common/mechanics/ranks/gather.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/contact/facet_spheres.hpp"

namespace gabion::mpm {

namespace {

// Share of an explicit step's own force, beyond the force that lasts, that is added to it.
constexpr double lasting_share = 0.2;

// Initial penetrations below this share of the radius count as none.
constexpr double rounding = 1e-9;

// The number that each facet of a surface has among others, -1: it is none of them.
template <int dim>
std::vector<std::int32_t> new_numbers(const ContactSurface<dim>& surface,
                                      std::span<const std::int32_t> facets) {
  const auto n = static_cast<std::size_t>(num_nodes(surface.facet_type));
  std::map<std::vector<std::int32_t>, std::int32_t> numbers;
  for (std::size_t f = 0; f < facets.size(); f += n) {
    numbers[{facets.begin() + f, facets.begin() + f + n}] = static_cast<std::int32_t>(f / n);
  }
  std::vector<std::int32_t> result;
  for (std::size_t f = 0; f < surface.facets.size(); f += n) {
    const auto found = numbers.find({surface.facets.begin() + f, surface.facets.begin() + f + n});
    result.push_back(found == numbers.end() ? -1 : found->second);
  }
  return result;
}

}  // namespace

template <int dim>
void FacetState<dim>::begin_step(const SoilSurface<dim>& soil) {
  comm_ = soil.comm;
  dt_ = soil.dt;
}

// A contact sphere without another contact goes back to its point.
template <int dim>
void FacetState<dim>::drop(std::size_t member) {
  Member& own = members_[member];
  own.energy.loss += own.energy.stored;
  own.energy.stored = own.stored_slip = 0;
  own.marks.clear();
  own.touches.clear();
  parts_.memory.forget_member(static_cast<std::int32_t>(member));
}

template <int dim>
void FacetState<dim>::set_facets(std::size_t member, std::span<const std::int32_t> facets) {
  Member& own = members_[member];
  const ContactSurface<dim>& surface = parts_.surface.member(member).surface;
  const auto kept = new_numbers(surface, facets);
  std::vector<double> left;  // point and normal of the contacts that go
  std::size_t last = 0;
  require(own.touches.size() == own.marks.size(),
          "found other facets right after a state was loaded, allowed: after an accepted step");
  for (std::size_t k = 0; k < own.marks.size(); ++k) {
    const std::int32_t facet = kept[own.marks[k].facet];
    if (facet >= 0) {
      own.marks[last] = own.marks[k];
      own.marks[last].facet = facet;
      own.touches[last++] = own.touches[k];
      continue;
    }
    own.energy.stored -= own.touches[k].stored;
    own.energy.loss += own.touches[k].stored;
    own.stored_slip -= own.touches[k].stored_slip;
    left.push_back(static_cast<double>(own.touches[k].id));
    left.insert(left.end(), own.marks[k].normal.begin(), own.marks[k].normal.end());
  }
  own.marks.resize(last);
  own.touches.resize(last);
  // Material points may be on another rank by now.
  const std::vector<double> all = gather_on_all<double>(comm_, left);
  for (std::size_t k = 0; k < all.size(); k += 1 + dim) {
    parts_.memory.leave(static_cast<std::int64_t>(all[k]), static_cast<std::int32_t>(member),
                        Eigen::Map<const Vector<dim>>(&all[k + 1]));
  }
}

template <int dim>
ContactMark<dim> FacetState<dim>::mark_of(const Point& contact) const {
  const Vector<dim>& n = contact.feature.normal;
  const auto& member = parts_.surface.member(contact.owner);
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
ContactFields<dim> FacetState<dim>::fields(const MaterialPoints<dim>& points, double reach,
                                           std::size_t member) const {
  const auto& own = parts_.surface.member(member);
  const auto vertices = parts_.surface.start_of(member);
  ContactFields<dim> fields({vertices.begin(), vertices.end()},
                            own.surface.facets.size() / num_nodes(own.surface.facet_type));
  if (own.dropped) return fields;
  spread_marks<dim>(own.surface, members_[member].marks, fields);
  const auto sphere_of = [&](std::int32_t p) -> ContactSphere<dim> {
    const std::int64_t id = points.id[p];
    return {parts_.memory.shape(id, points.depth[p]), parts_.memory.offset(id)};
  };
  add_gaps<dim>(own.surface, points, sphere_of, reach, fields);
  return fields;
}

// Force that lasts at the end of the step, of a contact that began with an initial penetration;
// other contacts have none. An implicit step, and the start of the run, has its own force.
template <int dim>
Vector<dim> FacetState<dim>::lasting_force(const Point& contact) const {
  Vector<dim> before = Vector<dim>::Zero();
  if (contact.initial_penetration <= rounding * contact.radius)
    return before;  // the slip's part along n
  if (!substeps_.has_substeps()) return contact.force;
  const Remembered* memory =
      going_on(parts_.points.candidate(contact).memory, contact.feature.normal, contact.owner);
  if (memory) before = memory->lasting;
  return before + lasting_share * (contact.force - before);
}

template <int dim>
RememberedContact<dim> FacetState<dim>::memory_of(const Point& contact) const {
  const Vector<dim>& n = contact.feature.normal;
  Remembered memory{.owner = contact.owner,
                    .normal = n,
                    .force = contact.force,
                    .slip = -contact.initial_penetration * n,
                    .part = contact.part,
                    .lasting = lasting_force(contact),
                    .took_weight = parts_.points.candidate(contact).took_weight};
  const ContactLaw law = parts_.points.law_of(contact, contact.part);
  if (law.mode == ContactMode::contact) {
    const Vector<dim> pull = contact.force - n.dot(contact.force) * n;
    memory.slip -= pull / (contact.area * law.tangential_penalty);
  }
  return memory;
}

template <int dim>
double FacetState<dim>::stored_in_slip(const Point& contact, const Remembered& memory) const {
  const double k = parts_.points.law_of(contact, contact.part).tangential_penalty;
  return 0.5 * contact.area * k * memory.tangential().squaredNorm();
}

template <int dim>
double FacetState<dim>::stored_in_depth(const Point& contact) const {
  const ContactLaw law = parts_.points.law_of(contact, 1);
  return contact.area * law.stored(contact.stored_depth);
}

template <int dim>
void FacetState<dim>::accept_contacts(std::size_t owner) {
  Member& member = members_[owner];
  const ContactMode mode = parts_.laws.mode(static_cast<std::int32_t>(owner));
  double work = 0, stored = 0, stored_slip = 0, slid = 0;
  member.marks.clear();
  member.touches.clear();
  for (const std::int32_t k : parts_.points.of(owner)) {
    const Point& contact = parts_.points.all()[k];
    deepest_ = std::max(deepest_, -contact.gap);
    member.marks.push_back(mark_of(contact));
    const Remembered memory = memory_of(contact);
    if (mode == ContactMode::contact) {
      const Vector<dim>& n = contact.feature.normal;
      const Vector<dim> pull = contact.force - n.dot(contact.force) * n;
      slid -= pull.dot(contact.slip - memory.tangential());
    }
    const double in_slip = stored_in_slip(contact, memory);
    stored_slip += in_slip;
    stored += stored_in_depth(contact) + in_slip;
    member.touches.push_back({.id = parts_.points.candidate(contact).id,
                              .stored = stored_in_depth(contact) + in_slip,
                              .stored_slip = in_slip});
    work -= contact.force.dot(contact.relative);
    parts_.memory.add(parts_.points.candidate(contact).id).push_back(memory);
  }
  if (substeps_.has_substeps()) {
    const auto& sums = substeps_.sums(owner);
    work = sums.normal_work + sums.tangential_work;
    slid = sums.tangential_work - (stored_slip - member.stored_slip);
  }
  member.energy.add_step(work, stored, slid);
  member.stored_slip = stored_slip;
}

template <int dim>
void FacetState<dim>::accept() {
  const auto before = parts_.memory.take_contacts();  // candidates refer to them
  deepest_ = 0;
  for (std::size_t owner = 0; owner < parts_.num_members(); ++owner) accept_contacts(owner);
  deepest_ = max_over_ranks(comm_, deepest_);
  accept_spheres(parts_);
  parts_.surface.accept();
  parts_.search.end_step();
  parts_.points.clear();
}

template <int dim>
ContactEnergy FacetState<dim>::energy() const {
  ContactEnergy sum;
  for (const Member& member : members_) {
    sum.stored += member.energy.stored;
    sum.friction += member.energy.friction;
    sum.loss += member.energy.loss;
  }
  return sum;
}

template <int dim>
void FacetState<dim>::visit_state(StateVisitor& visitor, const std::string& prefix) {
  parts_.surface.visit_vertices(visitor, prefix);
  visitor.real(prefix + "deepest", deepest_);
  parts_.memory.visit_state(visitor, prefix, parts_.num_members());
  for (std::size_t m = 0; m < parts_.num_members(); ++m) {
    Member& member = members_[m];
    const std::string own = fmt::format("{}member_{}.", prefix, m);
    parts_.surface.visit_member(m, visitor, own);
    const auto& surface = parts_.surface.member(m).surface;
    const std::vector<ContactMark<dim>> before = member.marks;
    visit_marks<dim>(visitor, own, surface.facets.size() / num_nodes(surface.facet_type),
                     member.marks);
    const bool same =
        std::ranges::equal(before, member.marks, {}, &ContactMark<dim>::x, &ContactMark<dim>::x);
    if (!same) member.touches.clear();
    const std::pair<const char*, double*> energies[] = {{"stored", &member.energy.stored},
                                                        {"friction", &member.energy.friction},
                                                        {"loss", &member.energy.loss},
                                                        {"stored_slip", &member.stored_slip}};
    for (const auto& [name, value] : energies) visitor.share(own + name, *value);
  }
}

template class FacetState<2>;
template class FacetState<3>;

}  // namespace gabion::mpm
