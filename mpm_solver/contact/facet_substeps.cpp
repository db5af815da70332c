// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/facet_substeps.hpp"

#include <algorithm>
#include <cmath>

#include "mpm_solver/contact/facet_assembly.hpp"

namespace gabion::mpm {

template <int dim>
void add_vertex_forces(const JointSurface<dim>& surface, const ContactPoint<dim>& point,
                       double share, std::span<double> forces) {
  const Simplex<dim>& simplex = surface.simplices()[point.feature.simplex];
  for (int k = 0; k < dim; ++k) {
    Eigen::Map<Vector<dim>>(forces.data() + std::ptrdiff_t{simplex[k]} * dim) -=
        share * point.feature.weights[k] * point.force;
  }
}

template <int dim>
void FacetSubsteps<dim>::add_lasting_forces(std::span<double> f) const {
  for (std::int32_t owner = 0; owner < parts_.surface.num_members(); ++owner) {
    add_remembered(parts_.search, owner, &RememberedContact<dim>::lasting, 1, f);
  }
}

template <int dim>
void FacetSubsteps<dim>::begin_substeps() {
  has_substeps_ = true;
  forces_.assign(parts_.surface.start().size() * dim, 0.0);
  sums_.assign(sums_.size(), Sums{});
}

template <int dim>
void FacetSubsteps<dim>::add_substep(std::span<const double> move, double share) {
  for (std::size_t owner = 0; owner < parts_.num_members(); ++owner) {
    int& closed = sums_[owner].closed;
    closed = std::max(closed, static_cast<int>(parts_.points.of(owner).size()));
  }
  for (const auto& contact : parts_.points.all()) {
    Sums& sums = sums_[contact.owner];
    const auto& c = parts_.points.candidate(contact);
    const double* w = parts_.points.weights_of(contact);
    const auto nodes = parts_.search.nodes_of(c);
    Vector<dim> relative =
        -share / parts_.surface.share() * parts_.surface.motion_at(contact.feature);
    for (std::int32_t k = 0; k < c.num_values; ++k) {
      const std::ptrdiff_t node = nodes[k];
      relative += w[k] * Eigen::Map<const Vector<dim>>(move.data() + node * dim);
    }
    const Vector<dim>& n = contact.feature.normal;
    const double normal = n.dot(contact.force) * n.dot(relative);
    sums.normal_work -= normal;
    sums.tangential_work -= contact.force.dot(relative) - normal;
    sums.resultant.add(contact.feature.x, -share * contact.force);
    add_vertex_forces<dim>(parts_.surface, contact, share, forces_);
  }
}

template <int dim>
void FacetSubsteps<dim>::add_stiffness_sums(std::span<double> sums) const {
  for (const std::int32_t index : parts_.points.by_owner()) {
    const auto& contact = parts_.points.all()[index];
    const auto& c = parts_.points.candidate(contact);
    const ContactLaw law = parts_.points.law_of(contact, contact.part);
    const double tangential = law.mode == ContactMode::contact ? law.tangential_penalty : 0;
    const double share = contact.num_others == 1 ? contact.shares[0] : 1;
    const double normal = 2 * law.penalty * contact.depth * share;
    const double k = contact.area * std::max(normal, tangential);
    const double* w = parts_.points.weights_of(contact);
    const auto on = parts_.search.nodes_of(c);
    double all = 0;
    for (std::int32_t i = 0; i < c.num_values; ++i) all += std::abs(w[i]);
    for (std::int32_t i = 0; i < c.num_values; ++i) {
      sums[on[i]] += k * std::abs(w[i]) * all;
    }
  }
}

template void add_vertex_forces<2>(const JointSurface<2>&, const ContactPoint<2>&, double,
                                   std::span<double>);
template void add_vertex_forces<3>(const JointSurface<3>&, const ContactPoint<3>&, double,
                                   std::span<double>);
template class FacetSubsteps<2>;
template class FacetSubsteps<3>;

}  // namespace gabion::mpm
