// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "mpm_solver/contact/contact_results.hpp"
#include "mpm_solver/contact/contact_substeps.hpp"
#include "mpm_solver/contact/facet_parts.hpp"

namespace gabion::mpm {

/// A contact by facets in the substeps of an explicit step: means and sums over them.
template <int dim>
class FacetSubsteps final : public ContactSubsteps<dim> {
 public:
  /// Means and sums of a member.
  struct Sums {
    ContactResultant<dim> resultant;
    double normal_work = 0, tangential_work = 0;  ///< of soil and surface on the contact [J]
    int closed = 0;                               ///< places that carried force, most of a substep
  };

  explicit FacetSubsteps(FacetParts<dim>& parts) : parts_(parts), sums_(parts.num_members()) {}

  /// Begin a step, which has no substeps as yet.
  void begin_step() { has_substeps_ = false; }
  /// Whether the step has substeps.
  bool has_substeps() const { return has_substeps_; }
  const Sums& sums(std::size_t member) const { return sums_[member]; }
  void forget(std::size_t member) { sums_[member] = {}; }
  /// Forces on the vertices of all members, means over the substeps [N].
  const std::vector<double>& forces() const { return forces_; }

  void add_lasting_forces(std::span<double> f) const override;
  void begin_substeps() override;
  void set_share(double share) override { parts_.surface.set_share(share); }
  void add_substep(std::span<const double> move, double share) override;
  void add_stiffness_sums(std::span<double> sums) const override;

 private:
  FacetParts<dim>& parts_;
  std::vector<Sums> sums_;  // of the members
  bool has_substeps_ = false;
  std::vector<double> forces_;
};

/// Add a share of the force at a contact point to the forces on the vertices of its simplex [N].
template <int dim>
void add_vertex_forces(const JointSurface<dim>& surface, const ContactPoint<dim>& point,
                       double share, std::span<double> forces);

}  // namespace gabion::mpm
