// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "mpm_solver/contact/facet_substeps.hpp"

namespace gabion::mpm {

/// Action of a contact by facets on its members in the current step: from its contact points, or
/// from its substeps.
template <int dim>
class FacetResults final : public ContactResults<dim> {
 public:
  /// Refers to both.
  FacetResults(const FacetParts<dim>& parts, const FacetSubsteps<dim>& substeps)
      : parts_(parts), substeps_(substeps) {}

  std::vector<double> forces_on_structure(std::size_t member = 0) const override;
  ContactResultant<dim> resultant(std::size_t member = 0) const override;
  ContactCounts counts(std::size_t member = 0) const override;

 private:
  const FacetParts<dim>& parts_;
  const FacetSubsteps<dim>& substeps_;
};

}  // namespace gabion::mpm
