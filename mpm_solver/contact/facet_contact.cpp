// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/facet_contact.hpp"

namespace gabion::mpm {

template <int dim>
void FacetContact<dim>::begin_step(const SoilSurface<dim>& soil) {
  assembly_.begin_step(soil.step_force_weight);
  state_.begin_step(soil);
  parts_.laws.begin_step(soil);
  parts_.points.clear();
  substeps_.begin_step();
  parts_.search.begin_step(soil, state_.deepest());
}

template <int dim>
bool FacetContact<dim>::drop(std::size_t member, bool dropped) {
  parts_.surface.drop(member, dropped);
  parts_.search.drop(member);
  substeps_.forget(member);
  if (dropped) state_.drop(member);
  return true;
}

template class FacetContact<2>;
template class FacetContact<3>;

}  // namespace gabion::mpm
