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

  void begin_step(const SoilSurface<dim>& soil) {
    cell_size_ = soil.cell_size;
    strength_factor_ = soil.strength_factor;
  }
  /// Mean size of the grid's cells in the step [m].
  double cell_size() const { return cell_size_; }
  ContactMode mode(std::int32_t owner) const { return members_[owner].mode; }

  /// The law between a candidate and a member, in dry soil.
  /// @param part  of the tangential stiffness
  ContactLaw law_of(const ContactCandidate<dim>& c, std::int32_t owner, double part) const;
  /// Let pore water bear its part of a traction along the normal n, by the pressure and the
  /// effective stress of the candidate's point when the step begins; none where the surface is
  /// drained and under suction.
  /// @param radius  of the contact sphere along n [m]
  void add_water(const ContactCandidate<dim>& c, std::int32_t owner, double radius,
                 const Vector<dim>& n, ContactLaw& law) const;

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
  double strength_factor_ = 1;
};

}  // namespace gabion::mpm
