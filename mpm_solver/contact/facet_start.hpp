// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "mpm_solver/contact/facet_assembly.hpp"
#include "mpm_solver/contact/penetration_at_rest.hpp"
#include "mpm_solver/contact/soil_surface.hpp"

namespace gabion::mpm {

/// Contact by facets with soil that lies on surfaces when the run begins, with or without stress.
template <int dim>
class FacetStart {
 public:
  /// Refers to both.
  FacetStart(FacetParts<dim>& parts, FacetAssembly<dim>& assembly)
      : parts_(parts), assembly_(assembly) {}

  /// Set contact spheres off to the surface that their soil lies on, and give those of soil under
  /// stress the depths and slips of its forces. Does nothing between steps.
  /// @returns whether soil is under stress: the contact points are then those of the start
  bool begin(const SoilAtRest<dim>& rest);

 private:
  using Candidate = ContactCandidate<dim>;
  using Places = std::span<const RestingPlace<dim>>;

  std::vector<RestingPlace<dim>> places_at_rest(Candidate& c, const SoilAtRest<dim>& rest);
  void set_off(Places places, Candidate& c);
  void remember_depths(Places places, Candidate& c);
  void remember_shear(const ContactPoint<dim>& contact, Places places);

  FacetParts<dim>& parts_;
  FacetAssembly<dim>& assembly_;
};

}  // namespace gabion::mpm
