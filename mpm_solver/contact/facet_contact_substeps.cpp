// SPDX-License-Identifier: BSD-3-Clause
// Contact by facets in the substeps of an explicit step.
#include <algorithm>
#include <cmath>

#include "mpm_solver/contact/facet_contact.hpp"

namespace gabion::mpm {

namespace {
constexpr double rounding = 1e-9;  // share of a radius: less is no depth that a touch began with
}

template <int dim>
void FacetContact<dim>::add_lasting_forces(std::span<double> f) const {
  for (std::int32_t owner = 0; owner < std::ssize(members_); ++owner) {
    add_remembered(owner, &Memory::lasting, 1, f);
  }
}

// At the end of the step, of a touch that began with a depth; of others nothing lasts. An implicit
// step, and the start of the run, is at its own force.
template <int dim>
Vector<dim> FacetContact<dim>::lasting_force(const Touch& touch) const {
  Vector<dim> before = Vector<dim>::Zero();
  if (touch.begun <= rounding * touch.radius) return before;  // the slip's part along n
  if (!has_substeps_) return touch.force;
  const Memory* memory =
      remembered(candidates_[touch.candidate], touch.feature.normal, touch.owner);
  if (memory) before = memory->lasting;
  return before + lasting_share * (touch.force - before);
}

template <int dim>
void FacetContact<dim>::begin_substeps() {
  has_substeps_ = true;
  substep_forces_.assign(start_.size() * dim, 0.0);
  for (Member& member : members_) member.substeps = {};
}

template <int dim>
void FacetContact<dim>::set_share(double share) {
  share_ = share;
  if (surface_motion_ == 0) return;  // neither do the surfaces in the whole step
  if (share == 1) {
    end_ = target_;
  } else {
    for (std::size_t v = 0; v < end_.size(); ++v) {
      end_[v] = start_[v] + share * (target_[v] - start_[v]);
    }
  }
  for (Member& member : members_) find_motion(member);
}

template <int dim>
void FacetContact<dim>::add_substep(std::span<const double> move, double share) {
  for (std::size_t owner = 0; owner < members_.size(); ++owner) {
    int& closed = members_[owner].substeps.closed;
    closed = std::max(closed, static_cast<int>(touches_of(owner).size()));
  }
  for (const Touch& touch : touches_) {
    Substeps& sums = members_[touch.owner].substeps;
    const Candidate& c = candidates_[touch.candidate];
    const double* w = weights_of(touch);
    Vector<dim> relative = -share / share_ * surface_motion(touch.feature);
    for (std::int32_t k = 0; k < c.num_values; ++k) {
      const std::ptrdiff_t node = nodes_[c.first_value + k];
      relative += w[k] * Eigen::Map<const Vector<dim>>(move.data() + node * dim);
    }
    const Vector<dim>& n = touch.feature.normal;
    const double normal = n.dot(touch.force) * n.dot(relative);
    sums.normal_work -= normal;
    sums.tangential_work -= touch.force.dot(relative) - normal;
    sums.resultant.add(touch.feature.x, -share * touch.force);
    add_vertex_forces(touch, share, substep_forces_);
  }
}

template <int dim>
void FacetContact<dim>::add_stiffness_sums(std::span<double> sums) const {
  for (const std::int32_t index : by_owner_) {
    const Touch& touch = touches_[index];
    const Candidate& c = candidates_[touch.candidate];
    const ContactLaw law = law_of(c, touch.owner, touch.part);
    const double tangential = law.mode == ContactMode::contact ? law.tangential_penalty : 0;
    const double share = touch.num_others == 1 ? touch.shares[0] : 1;
    const double normal = 2 * law.penalty * touch.depth * share;
    const double k = touch.area * std::max(normal, tangential);
    const double* w = weights_of(touch);
    double all = 0;
    for (std::int32_t i = 0; i < c.num_values; ++i) all += std::abs(w[i]);
    for (std::int32_t i = 0; i < c.num_values; ++i) {
      sums[nodes_[c.first_value + i]] += k * std::abs(w[i]) * all;
    }
  }
}

template <int dim>
void FacetContact<dim>::mark_touched(std::span<char> nodes, std::size_t member) const {
  for (const std::int32_t index : touches_of(member)) {
    const Candidate& c = candidates_[touches_[index].candidate];
    for (std::int32_t k = 0; k < c.num_values; ++k) nodes[nodes_[c.first_value + k]] = 1;
  }
}

template class FacetContact<2>;
template class FacetContact<3>;

}  // namespace gabion::mpm
