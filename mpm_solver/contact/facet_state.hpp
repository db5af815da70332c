// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "mpm_solver/contact/contact_state.hpp"
#include "mpm_solver/contact/facet_start.hpp"
#include "mpm_solver/contact/facet_substeps.hpp"

namespace gabion::mpm {

/// The accepted state of a contact by facets: its memory, and what each member did in the accepted
/// step.
template <int dim>
class FacetState final : public ContactState<dim> {
 public:
  /// Refers to all of them.
  FacetState(FacetParts<dim>& parts, FacetAssembly<dim>& assembly,
             const FacetSubsteps<dim>& substeps)
      : parts_(parts),
        substeps_(substeps),
        start_(parts, assembly),
        members_(parts.num_members()) {}

  void begin_step(const SoilSurface<dim>& soil);
  /// Largest penetration in the accepted step, of all ranks [m].
  double deepest() const { return deepest_; }
  /// Make the end of the step the accepted state. Collective.
  void accept();
  /// Forget a member; the energy of its springs is lost.
  void drop(std::size_t member);

  /// A member will have these facets: contacts on others are forgotten, what their springs hold is
  /// lost. Collective.
  void set_facets(std::size_t member, std::span<const std::int32_t> facets);

  void begin_at_rest(const SoilAtRest<dim>& rest) override;
  ContactEnergy energy() const override;
  ContactFields<dim> fields(const MaterialPoints<dim>& points, double reach,
                            std::size_t member = 0) const override;
  std::span<const ContactMark<dim>> marks(std::size_t member = 0) const override {
    return members_[member].marks;
  }
  std::span<const Vector<dim>> accepted_vertices(std::size_t member) const override {
    if (parts_.surface.member(member).dropped) return {};
    return parts_.surface.start_of(member);
  }
  void give(std::span<const std::int64_t> ids, Packet& packet) override {
    parts_.memory.give(ids, packet);
  }
  void take(Packet& packet) override { parts_.memory.take(packet); }
  void visit_state(StateVisitor& visitor, const std::string& prefix) override;

 private:
  using Point = ContactPoint<dim>;
  using Remembered = RememberedContact<dim>;
  /// A contact point of the accepted step, as its mark.
  struct Touch {
    std::int64_t id = 0;                 // of the material point
    double stored = 0, stored_slip = 0;  // in its springs [J]
  };
  /// Action of a member in the accepted step.
  struct Member {
    std::vector<ContactMark<dim>> marks;
    std::vector<Touch> touches;  // of each mark; empty where a state was loaded since
    ContactEnergy energy;
    double stored_slip = 0;  // part of its energy in tangential springs [J]
  };

  void accept_contacts(std::size_t owner);
  Remembered memory_of(const Point& contact) const;
  Vector<dim> lasting_force(const Point& contact) const;
  double stored_in_slip(const Point& contact, const Remembered& memory) const;
  double stored_in_depth(const Point& contact) const;
  ContactMark<dim> mark_of(const Point& contact) const;
  void remember_contacts(const SoilAtRest<dim>& rest);

  FacetParts<dim>& parts_;
  const FacetSubsteps<dim>& substeps_;
  FacetStart<dim> start_;
  std::vector<Member> members_;
  double deepest_ = 0;
  MPI_Comm comm_ = MPI_COMM_SELF;
  double dt_ = 0;  // of the current step [s]
};

}  // namespace gabion::mpm
