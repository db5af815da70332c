// SPDX-License-Identifier: BSD-3-Clause
// Contact by facets in the substeps of an explicit step.
#include <algorithm>
#include <cmath>

#include "mpm_solver/contact/facet_contact.hpp"

namespace gabion::mpm {

template <int dim>
void FacetContact<dim>::begin_substeps() {
  substeps_.emplace();
  substeps_->forces.assign(start_.size() * dim, 0.0);
}

template <int dim>
void FacetContact<dim>::set_share(double share) {
  share_ = share;
  if (share == 1) {
    end_ = target_;
  } else {
    for (std::size_t v = 0; v < end_.size(); ++v) {
      end_[v] = start_[v] + share * (target_[v] - start_[v]);
    }
  }
  surface_motion_ = 0;
  for (std::size_t v = 0; v < end_.size(); ++v) {
    surface_motion_ = std::max(surface_motion_, (end_[v] - start_[v]).norm());
  }
}

template <int dim>
void FacetContact<dim>::add_substep(std::span<const double> move, double share) {
  substeps_->closed = std::max(substeps_->closed, static_cast<int>(touches_.size()));
  for (const Touch& touch : touches_) {
    const Candidate& c = candidates_[touch.candidate];
    const double* w = weights_of(touch);
    Vector<dim> relative = -share / share_ * surface_motion(touch.feature);
    for (std::int32_t k = 0; k < c.num_values; ++k) {
      const std::ptrdiff_t node = nodes_[c.first_value + k];
      relative += w[k] * Eigen::Map<const Vector<dim>>(move.data() + node * dim);
    }
    const Vector<dim>& n = touch.feature.normal;
    const double normal = n.dot(touch.force) * n.dot(relative);
    substeps_->normal_work -= normal;
    substeps_->tangential_work -= touch.force.dot(relative) - normal;
    substeps_->resultant.add(touch.feature.x, -share * touch.force);
    add_vertex_forces(touch, share, substeps_->forces);
  }
}

template <int dim>
void FacetContact<dim>::add_stiffness_sums(std::span<double> sums) const {
  for (const Touch& touch : touches_) {
    const Candidate& c = candidates_[touch.candidate];
    const ContactLaw law = law_of(c, touch.part);
    const double tangential = mode_ == ContactMode::contact ? law.tangential_penalty : 0;
    const double k = touch.area * std::max(2 * law.penalty * touch.depth, tangential);
    const double* w = weights_of(touch);
    double all = 0;
    for (std::int32_t i = 0; i < c.num_values; ++i) all += std::abs(w[i]);
    for (std::int32_t i = 0; i < c.num_values; ++i) {
      sums[nodes_[c.first_value + i]] += k * std::abs(w[i]) * all;
    }
  }
}

template class FacetContact<2>;
template class FacetContact<3>;

}  // namespace gabion::mpm
