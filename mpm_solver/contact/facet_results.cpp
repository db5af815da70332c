// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/facet_results.hpp"

#include <algorithm>

namespace gabion::mpm {

template <int dim>
std::vector<double> FacetResults<dim>::forces_on_structure(std::size_t member) const {
  std::vector<double> forces = substeps_.forces();
  if (!substeps_.has_substeps()) {
    forces.assign(parts_.surface.start().size() * dim, 0.0);
    for (const std::int32_t k : parts_.points.of(member)) {
      add_vertex_forces<dim>(parts_.surface, parts_.points.all()[k], 1, forces);
    }
  }
  const auto& own = parts_.surface.member(member);
  const auto first = forces.begin() + std::ptrdiff_t{own.first_vertex} * dim;
  return {first, first + std::ptrdiff_t{own.num_vertices} * dim};
}

template <int dim>
ContactResultant<dim> FacetResults<dim>::resultant(std::size_t member) const {
  if (substeps_.has_substeps()) return substeps_.sums(member).resultant;
  ContactResultant<dim> sum;
  const auto& contacts = parts_.points.all();
  for (const std::int32_t k : parts_.points.of(member)) {
    sum.add(contacts[k].feature.x, -contacts[k].force);
  }
  return sum;
}

template <int dim>
ContactCounts FacetResults<dim>::counts(std::size_t member) const {
  ContactCounts result;
  for (const std::int32_t k : parts_.points.of(member)) {
    const ContactPoint<dim>& contact = parts_.points.all()[k];
    ++result.closed;
    result.sliding += contact.traction.sliding;
    result.penetration = std::max(result.penetration, -contact.gap - contact.initial_penetration);
  }
  if (substeps_.has_substeps())
    result.closed = std::max(result.closed, substeps_.sums(member).closed);
  return result;
}

template class FacetResults<2>;
template class FacetResults<3>;

}  // namespace gabion::mpm
