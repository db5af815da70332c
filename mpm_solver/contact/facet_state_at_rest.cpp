// SPDX-License-Identifier: BSD-3-Clause
// The accepted state of a contact by facets that begins with soil at rest.
#include <algorithm>

#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/contact/facet_state.hpp"

namespace gabion::mpm {

template <int dim>
void FacetState<dim>::begin_at_rest(const SoilAtRest<dim>& rest) {
  if (start_.begin(rest)) remember_contacts(rest);
}

// Make the contacts, as they are, the accepted state.
template <int dim>
void FacetState<dim>::remember_contacts(const SoilAtRest<dim>& rest) {
  parts_.memory.take_contacts();
  for (Member& member : members_) {
    member.energy = {};
    member.stored_slip = 0;
  }
  for (const Point& contact : parts_.points.all()) {
    // Soil that is free of stress is in contact by rounding at most: its contact has not started.
    if (!rest.is_stressed[parts_.points.candidate(contact).body]) continue;
    const Remembered memory = memory_of(contact);
    Member& member = members_[contact.owner];
    member.stored_slip += stored_in_slip(contact, memory);
    member.energy.stored += stored_in_depth(contact) + stored_in_slip(contact, memory);
    deepest_ = std::max(deepest_, -contact.gap);
    parts_.memory.add(parts_.points.candidate(contact).id).push_back(memory);
  }
  deepest_ = max_over_ranks(comm_, deepest_);
  parts_.search.refer_to_memory();
}

template void FacetState<2>::begin_at_rest(const SoilAtRest<2>&);
template void FacetState<3>::begin_at_rest(const SoilAtRest<3>&);

}  // namespace gabion::mpm
