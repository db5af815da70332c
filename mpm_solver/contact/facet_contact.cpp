// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/facet_contact.hpp"

#include "common/base/error.hpp"

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

template <int dim>
bool FacetContact<dim>::set_facets(const std::string& name, std::span<const std::int32_t> facets) {
  for (std::size_t member = 0; member < parts_.num_members(); ++member) {
    if (parts_.surface.member(member).name != name) continue;
    state_.set_facets(member, facets);
    parts_.surface.set_facets(member, {facets.begin(), facets.end()});
    return true;
  }
  return false;
}

template <int dim>
void set_facets(const Contacts<dim>& contacts, const std::string& interface,
                std::span<const std::int32_t> facets) {
  for (const auto& contact : contacts) {
    auto* by_facets = dynamic_cast<FacetContact<dim>*>(contact.get());
    if (by_facets != nullptr && by_facets->set_facets(interface, facets)) return;
  }
  throw Error("interface \"" + interface +
              "\": found other facets, allowed with the contact method \"facets\" alone");
}

template class FacetContact<2>;
template class FacetContact<3>;
template void set_facets(const Contacts<2>&, const std::string&, std::span<const std::int32_t>);
template void set_facets(const Contacts<3>&, const std::string&, std::span<const std::int32_t>);

}  // namespace gabion::mpm
