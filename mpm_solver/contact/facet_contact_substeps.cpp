// SPDX-License-Identifier: BSD-3-Clause
// Contact by facets in the substeps of an explicit step.
#include <algorithm>
#include <cmath>

#include "mpm_solver/contact/facet_contact.hpp"

namespace gabion::mpm {

namespace {
constexpr double rounding = 1e-9;  // share of a radius: less is no depth that a contact began with
}

template <int dim>
void FacetContact<dim>::add_lasting_forces(std::span<double> f) const {
  for (std::int32_t owner = 0; owner < std::ssize(members_); ++owner) {
    add_remembered(owner, &Remembered::lasting, 1, f);
  }
}

// Force that lasts at the end of the step, of a contact that began with an initial penetration;
// other contacts have none. An implicit step, and the start of the run, has its own force.
template <int dim>
Vector<dim> FacetContact<dim>::lasting_force(const ContactPoint& contact) const {
  Vector<dim> before = Vector<dim>::Zero();
  if (contact.initial_penetration <= rounding * contact.radius)
    return before;  // the slip's part along n
  if (!has_substeps_) return contact.force;
  const Remembered* memory =
      going_on(candidate(contact).memory, contact.feature.normal, contact.owner);
  if (memory) before = memory->lasting;
  return before + lasting_share * (contact.force - before);
}

template <int dim>
void FacetContact<dim>::begin_substeps() {
  has_substeps_ = true;
  substep_forces_.assign(surface_.start().size() * dim, 0.0);
  for (Member& member : members_) member.substeps = {};
}

template <int dim>
void FacetContact<dim>::add_substep(std::span<const double> move, double share) {
  for (std::size_t owner = 0; owner < members_.size(); ++owner) {
    int& closed = members_[owner].substeps.closed;
    closed = std::max(closed, static_cast<int>(contacts_of(owner).size()));
  }
  for (const ContactPoint& contact : contacts_) {
    Substeps& sums = members_[contact.owner].substeps;
    const Candidate& c = candidate(contact);
    const double* w = weights_of(contact);
    const auto nodes = search_.nodes_of(c);
    Vector<dim> relative = -share / surface_.share() * surface_.motion_at(contact.feature);
    for (std::int32_t k = 0; k < c.num_values; ++k) {
      const std::ptrdiff_t node = nodes[k];
      relative += w[k] * Eigen::Map<const Vector<dim>>(move.data() + node * dim);
    }
    const Vector<dim>& n = contact.feature.normal;
    const double normal = n.dot(contact.force) * n.dot(relative);
    sums.normal_work -= normal;
    sums.tangential_work -= contact.force.dot(relative) - normal;
    sums.resultant.add(contact.feature.x, -share * contact.force);
    add_vertex_forces(contact, share, substep_forces_);
  }
}

template <int dim>
void FacetContact<dim>::add_stiffness_sums(std::span<double> sums) const {
  for (const std::int32_t index : by_owner_) {
    const ContactPoint& contact = contacts_[index];
    const Candidate& c = candidate(contact);
    const ContactLaw law = law_of(c, contact.owner, contact.part);
    const double tangential = law.mode == ContactMode::contact ? law.tangential_penalty : 0;
    const double share = contact.num_others == 1 ? contact.shares[0] : 1;
    const double normal = 2 * law.penalty * contact.depth * share;
    const double k = contact.area * std::max(normal, tangential);
    const double* w = weights_of(contact);
    const auto on = search_.nodes_of(c);
    double all = 0;
    for (std::int32_t i = 0; i < c.num_values; ++i) all += std::abs(w[i]);
    for (std::int32_t i = 0; i < c.num_values; ++i) {
      sums[on[i]] += k * std::abs(w[i]) * all;
    }
  }
}

template <int dim>
void FacetContact<dim>::mark_touched(std::span<char> nodes, std::size_t member) const {
  for (const std::int32_t index : contacts_of(member)) {
    for (const std::int32_t node : search_.nodes_of(candidate(contacts_[index]))) nodes[node] = 1;
  }
}

template class FacetContact<2>;
template class FacetContact<3>;

}  // namespace gabion::mpm
