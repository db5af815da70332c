// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "mpm_solver/contact/contact_points.hpp"

namespace gabion::mpm {

/// The parts that the classes of a contact by facets share. The parts refer to each other.
template <int dim>
struct FacetParts {
  /// @param members  not empty, all with FacetSettings
  explicit FacetParts(const std::vector<const ContactSettings<dim>*>& members)
      : surface(members), laws(members, surface, search) {}
  FacetParts(const FacetParts&) = delete;
  FacetParts& operator=(const FacetParts&) = delete;
  FacetParts(FacetParts&&) = delete;
  FacetParts& operator=(FacetParts&&) = delete;
  ~FacetParts() = default;

  std::size_t num_members() const { return static_cast<std::size_t>(surface.num_members()); }

  JointSurface<dim> surface;
  ContactMemory<dim> memory;
  PointSearch<dim> search{surface, memory};
  FacetLaws<dim> laws;
  ContactPoints<dim> points{surface, search, laws};
};

}  // namespace gabion::mpm
