// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "mpm_solver/contact/contact.hpp"
#include "mpm_solver/contact/facet_results.hpp"
#include "mpm_solver/contact/facet_state.hpp"

namespace gabion::mpm {

/// Material points against the facets of surfaces (docs/theory/interface.md), its members. A point
/// has a contact sphere of radius R, as deep as the point lies in the cell that it was laid in; the
/// sphere is in contact where the distance of its centre y from the surface has a local minimum x_m
/// below R:
///
///     g = (y - x_m) . n - R + n . sum_i (w_i - N_i) du_i ,  y = x_p + o + sum_i N_i du_i ,
///     d = o - R n ,  w_i = N_i(x_p) + grad N_i(x_p) . d ,
///     f_i = w_i A t ,  on vertex v  -phi_v A t ,  A = V / (2 R)
///
/// w are the basis functions of the point continued to the surface of its sphere, for gimp and
/// bspline by SurfaceValues: linear fields are met exactly, and force and place are those of both
/// sides. The sphere of an elastic body is strained with it; the offset o carries the remaining
/// displacement of the surface relative to the centre from step to step. Penetration and friction
/// follow ContactLaw; in re-entrant corners depths are those of ShortestExit. A contact point of
/// soil that was at rest under stress when the run began has the depth of that stress from the
/// beginning: its gap is less by it. The slip of a point that was open begins where it comes into
/// contact, its displacement path in the step being straight. The force F of a step is constant in
/// it (NewmarkBossak::step_force_weight): contact then dissipates energy or keeps it, at any
/// stiffness and dt.
///
/// The members are one surface for the search: where their rims meet, nothing but the friction and
/// the owner of the forces changes. Where two of them meet in a corner each pushes independently
/// (surface_features.hpp). PointSearch finds the places, ContactPoints are the places in contact in
/// the step, and ContactMemory has what is remembered of them.
///
/// Each rank carries its own material points, and looks as far ahead as all ranks together would.
/// @see Kane, Repetto, Ortiz, Marsden (1999) for the time law; Bird et al. (2024) for points and
///      facets
template <int dim>
class FacetContact final : public Contact<dim> {
 public:
  /// @param members  not empty, all with FacetSettings
  explicit FacetContact(const std::vector<const ContactSettings<dim>*>& members)
      : parts_(members) {}

  void begin_step(const SoilSurface<dim>& soil) override;
  bool can_touch(std::size_t member = 0) const override { return parts_.search.can_touch(member); }
  void set_displacement(std::span<const double> displacement, std::size_t member = 0) override {
    parts_.surface.set_displacement(displacement, member);
  }
  double allowed_motion(std::size_t member = 0) const override {
    return parts_.search.allowed_motion(member);
  }
  double approach_step(double dt, double margin) const override {
    return parts_.search.approach_step(dt, margin);
  }
  void accept() override { state_.accept(); }
  std::size_t num_members() const override { return parts_.num_members(); }
  bool drop(std::size_t member, bool dropped) override;
  /// Let a member have other facets from now on, of the same vertices: what it remembers of those
  /// that it has no more is forgotten, and what their springs hold is lost. Between steps;
  /// collective. @returns false: no member has this name
  bool set_facets(const std::string& name, std::span<const std::int32_t> facets);

  ContactAssembly<dim>& assembly() override { return assembly_; }
  ContactSubsteps<dim>& substeps() override { return substeps_; }
  const ContactResults<dim>& results() const override { return results_; }
  ContactState<dim>& state() override { return state_; }

 private:
  FacetParts<dim> parts_;
  FacetAssembly<dim> assembly_{parts_};
  FacetSubsteps<dim> substeps_{parts_};
  FacetResults<dim> results_{parts_, substeps_};
  FacetState<dim> state_{parts_, assembly_, substeps_};
};

/// FacetContact::set_facets of the contact that has an interface.
/// @throws Error  its method is another one
template <int dim>
void set_facets(const Contacts<dim>& contacts, const std::string& interface,
                std::span<const std::int32_t> facets);

}  // namespace gabion::mpm
