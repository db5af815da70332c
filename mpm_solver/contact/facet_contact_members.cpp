// SPDX-License-Identifier: BSD-3-Clause
// The members of a contact by facets, and what the contact points of each come to.
#include <algorithm>
#include <cmath>

#include "mpm_solver/contact/facet_contact.hpp"

namespace gabion::mpm {

template <int dim>
FacetContact<dim>::FacetContact(const std::vector<const ContactSettings<dim>*>& members)
    : surface_(members) {
  for (const auto* settings : members) {
    Member& member = members_.emplace_back();
    member.mode = settings->mode;
    member.friction = settings->friction;
    member.drained = settings->drained;
    member.drag = settings->drag;
    member.weakening = settings->weakening;
    member.method = std::get<FacetSettings>(settings->method);
  }
  order_contacts();
}

template <int dim>
void FacetContact<dim>::begin_step(const SoilSurface<dim>& soil) {
  force_weight_ = soil.step_force_weight;
  cell_size_ = soil.cell_size;
  dt_ = soil.dt;
  comm_ = soil.comm;
  contacts_.clear();
  order_contacts();
  has_substeps_ = false;
  search_.begin_step(soil, deepest_);
}

// A contact sphere that touched nothing else goes back to its point.
template <int dim>
bool FacetContact<dim>::drop(std::size_t member, bool dropped) {
  Member& own = members_[member];
  surface_.drop(member, dropped);
  search_.drop(member);
  own.substeps = {};
  if (!dropped) return true;
  own.energy.loss += own.energy.stored;
  own.energy.stored = own.stored_slip = 0;
  own.marks.clear();
  memory_.forget_member(static_cast<std::int32_t>(member));
  return true;
}

// Touches in the order in which their members stand, those of a member as they were found.
template <int dim>
void FacetContact<dim>::order_contacts() {
  first_of_.assign(members_.size() + 1, 0);
  for (const ContactPoint& contact : contacts_) ++first_of_[contact.owner + 1];
  for (std::size_t m = 0; m < members_.size(); ++m) first_of_[m + 1] += first_of_[m];
  by_owner_.resize(contacts_.size());
  std::vector<std::int32_t> next(first_of_.begin(), first_of_.end() - 1);
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    by_owner_[next[contacts_[k].owner]++] = static_cast<std::int32_t>(k);
  }
}

template <int dim>
void FacetContact<dim>::add_vertex_forces(const ContactPoint& contact, double share,
                                          std::span<double> forces) const {
  const Simplex<dim>& simplex = surface_.simplices()[contact.feature.simplex];
  for (int k = 0; k < dim; ++k) {
    Eigen::Map<Vector<dim>>(forces.data() + std::ptrdiff_t{simplex[k]} * dim) -=
        share * contact.feature.weights[k] * contact.force;
  }
}

template <int dim>
std::vector<double> FacetContact<dim>::forces_on_structure(std::size_t member) const {
  std::vector<double> forces = substep_forces_;
  if (!has_substeps_) {
    forces.assign(surface_.start().size() * dim, 0.0);
    for (const std::int32_t k : contacts_of(member)) add_vertex_forces(contacts_[k], 1, forces);
  }
  const auto& own = surface_.member(member);
  const auto first = forces.begin() + std::ptrdiff_t{own.first_vertex} * dim;
  return {first, first + std::ptrdiff_t{own.num_vertices} * dim};
}

template <int dim>
typename Contact<dim>::Resultant FacetContact<dim>::resultant(std::size_t member) const {
  if (has_substeps_) return members_[member].substeps.resultant;
  typename Contact<dim>::Resultant sum;
  for (const std::int32_t k : contacts_of(member)) {
    sum.add(contacts_[k].feature.x, -contacts_[k].force);
  }
  return sum;
}

template <int dim>
double FacetContact<dim>::work_on_soil(std::span<const double>) const {
  double sum = 0;
  for (std::size_t owner = 0; owner < members_.size(); ++owner) {
    double work = 0;
    for (const std::int32_t k : contacts_of(owner)) {
      work += contacts_[k].motion.dot(contacts_[k].force);
    }
    sum += work;
  }
  return sum;
}

template <int dim>
ContactCounts FacetContact<dim>::counts(std::size_t member) const {
  ContactCounts result;
  for (const std::int32_t k : contacts_of(member)) {
    const ContactPoint& contact = contacts_[k];
    ++result.closed;
    result.sliding += contact.traction.sliding;
    result.penetration = std::max(result.penetration, -contact.gap - contact.initial_penetration);
  }
  if (has_substeps_) result.closed = std::max(result.closed, members_[member].substeps.closed);
  return result;
}

template <int dim>
ContactEnergy FacetContact<dim>::energy() const {
  ContactEnergy sum;
  for (const Member& member : members_) {
    sum.stored += member.energy.stored;
    sum.friction += member.energy.friction;
    sum.loss += member.energy.loss;
  }
  return sum;
}

template class FacetContact<2>;
template class FacetContact<3>;

}  // namespace gabion::mpm
