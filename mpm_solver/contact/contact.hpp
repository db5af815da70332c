// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "mpm_solver/contact/contact_assembly.hpp"
#include "mpm_solver/contact/contact_results.hpp"
#include "mpm_solver/contact/contact_settings.hpp"
#include "mpm_solver/contact/contact_state.hpp"
#include "mpm_solver/contact/contact_substeps.hpp"

namespace gabion::mpm {

/// Contact of the soil with one or several surfaces, its members: equal and opposite forces act
/// between them, by a method of their own. A step: begin_step; then set_displacement and
/// assembly().add_forces as often as wanted; then accept, or the next begin_step. Forces, counts
/// and energies are those that this rank carries: their sums over the ranks are those of the
/// contact.
template <int dim>
class Contact {
 public:
  Contact() = default;
  Contact(const Contact&) = delete;
  Contact& operator=(const Contact&) = delete;
  Contact(Contact&&) = delete;
  Contact& operator=(Contact&&) = delete;
  virtual ~Contact() = default;

  /// Whether it reads SoilSurface::occupied.
  virtual bool asks_for_cells() const { return false; }
  /// Grid nodes that the coming step needs on this rank besides those of this rank's material
  /// points.
  /// @param soil  without weights and nodes as yet
  virtual std::vector<std::int32_t> find_nodes(const SoilSurface<dim>& soil) {
    static_cast<void>(soil);
    return {};
  }
  /// Start a step from the accepted state: find the soil that may come into contact with the
  /// surface in it. Collective over soil.comm.
  virtual void begin_step(const SoilSurface<dim>& soil) = 0;
  /// Whether a force can arise in this step.
  virtual bool can_touch(std::size_t member = 0) const = 0;
  /// Displacement of a member at the end of the step, num_vertices x dim, from the reference.
  virtual void set_displacement(std::span<const double> displacement, std::size_t member = 0) = 0;
  /// Search margin: how far beyond twice its displacement by the velocity of fastest_about a
  /// material point of this rank may move before the candidates of begin_step may be incomplete
  /// [m]; infinite: the method does not look ahead.
  virtual double allowed_motion(std::size_t member = 0) const {
    static_cast<void>(member);
    return std::numeric_limits<double>::infinity();
  }
  /// Largest next step [s] in which the surface goes no deeper into the soil than `margin` [m],
  /// where it is open beyond its gap, at its speed in the current step, of length dt; infinite when
  /// it comes no nearer.
  virtual double approach_step(double dt, double margin) const = 0;
  /// Make the end of the step the accepted state.
  virtual void accept() = 0;
  virtual std::size_t num_members() const { return 1; }
  /// Let a member act no more, where the energy of its springs is lost; or act again, from a state
  /// that is loaded next. @returns false: the method cannot, the contact has to be replaced
  virtual bool drop(std::size_t member, bool dropped) {
    static_cast<void>(member), static_cast<void>(dropped);
    return false;
  }

  virtual ContactAssembly<dim>& assembly() = 0;
  virtual ContactSubsteps<dim>& substeps() { return no_substeps_; }
  virtual const ContactResults<dim>& results() const = 0;
  virtual ContactState<dim>& state() = 0;

 private:
  ContactSubsteps<dim> no_substeps_;
};

/// A contact whose class is all of its parts but the substeps.
template <int dim>
class WholeContact : public Contact<dim>,
                     public ContactAssembly<dim>,
                     public ContactResults<dim>,
                     public ContactState<dim> {
 public:
  ContactAssembly<dim>& assembly() final { return *this; }
  const ContactResults<dim>& results() const final { return *this; }
  ContactState<dim>& state() final { return *this; }
};

template <int dim>
using Contacts = std::vector<std::unique_ptr<Contact<dim>>>;

/// The contact of the method that the settings ask for.
template <int dim>
std::unique_ptr<Contact<dim>> make_contact(const ContactSettings<dim>& settings);

/// One contact of surfaces that all have the method `facets`: the contact points of a material
/// point are searched as if they were one surface.
/// @param members  not empty
template <int dim>
std::unique_ptr<Contact<dim>> make_joint_contact(
    const std::vector<const ContactSettings<dim>*>& members);

}  // namespace gabion::mpm
