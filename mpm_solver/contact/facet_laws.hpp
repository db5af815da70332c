// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "mpm_solver/contact/point_search.hpp"

namespace gabion::mpm {

/// The laws of contact at the facets of the members, for the candidates of a step.
template <int dim>
class FacetLaws {
 public:
  /// Refers to the surface and the search.
  /// @param members  all with FacetSettings
  FacetLaws(const std::vector<const ContactSettings<dim>*>& members,
            const JointSurface<dim>& surface, const PointSearch<dim>& search);

  void begin_step(const SoilSurface<dim>& soil) { cell_size_ = soil.cell_size; }
  /// Mean size of the grid's cells in the step [m].
  double cell_size() const { return cell_size_; }
  ContactMode mode(std::int32_t owner) const { return members_[owner].mode; }

  /// The law between a candidate and a member, in dry soil.
  /// @param part  of the tangential stiffness
  ContactLaw law_of(const ContactCandidate<dim>& c, std::int32_t owner, double part) const;
  /// The pore pressure at the surface [Pa]: 0 where it is drained, else that without flow along its
  /// normal.
  /// @param radius  of the contact sphere along the normal n [m]
  double pore_pressure_at(const ContactCandidate<dim>& c, std::int32_t owner, double radius,
                          const Vector<dim>& n) const;

 private:
  struct Member {
    ContactMode mode = ContactMode::contact;
    double friction = -1, drag = 0;
    FrictionFall weakening{};
    bool drained = false;
    FacetSettings method;
  };

  const JointSurface<dim>& surface_;
  const PointSearch<dim>& search_;
  std::vector<Member> members_;
  double cell_size_ = 0;
};

}  // namespace gabion::mpm
