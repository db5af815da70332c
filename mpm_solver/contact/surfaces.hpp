// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include "mpm_solver/contact/body_groups.hpp"
#include "mpm_solver/contact/contact.hpp"
#include "mpm_solver/contact/seams.hpp"
#include "mpm_solver/points/pool.hpp"

namespace gabion::mpm {

template <int dim>
class GroupContact;

/// All surfaces that may be in contact with the soil: the interfaces, then the rigid walls. Those
/// of the method `facets` that meet are one contact, see joint_surfaces. Last comes the contact
/// between groups of bodies, which has no surface. Refers to their settings.
template <int dim>
class Surfaces {
 public:
  /// @param cell_size  mean [m]
  Surfaces(MPI_Comm comm, const std::vector<ContactSettings<dim>>& interfaces,
           const std::vector<RigidWallSettings<dim>>& walls, double cell_size);

  /// Let groups of bodies meet. @param num_places  nodes of the grid
  void add_groups(const BodyGroups& groups, std::int32_t num_places);

  const Contacts<dim>& contacts() const { return contacts_; }
  std::size_t size() const { return places_.size(); }
  std::vector<InterfaceMesh> interface_meshes() const;
  const ContactSettings<dim>& settings(std::size_t surface) const;

  /// Whether a contact asks for occupied cells.
  bool asks_for_cells() const;
  /// Grid nodes of all Contact::find_nodes, some of them several times.
  std::vector<std::int32_t> find_nodes(const SoilSurface<dim>& soil);
  /// Drop the rigid walls that are neither named nor boulders: they no longer act, for the rest of
  /// the run.
  void keep_walls(std::span<const std::string> names);
  /// No surface acts any more, for the rest of the run.
  void drop_all();

  /// @note Collective.
  void begin_step(const SoilSurface<dim>& soil);
  /// Whether the stiffness of this step is symmetric.
  bool symmetric() const { return symmetric_; }
  /// Whether soil can be in contact with an interface in this step: the coupling may then ask for
  /// several solutions.
  bool may_touch_interface() const;
  /// Mark nodes by ContactAssembly::mark_touched of all interfaces.
  void mark_touched(std::span<char> nodes) const;
  /// Let pools press on the front of all surfaces from now on, besides the soil; their force is on
  /// the first rank.
  void set_pools(const PoolLevels& pools) { pools_ = pools; }
  /// Give the interfaces their displacements, 0 to those that received none.
  void receive(const InterfaceValues& displacements);
  /// Move the rigid walls that are no boulders to where they are at a time [s].
  void move_walls(double time);
  /// Move the surface of a boulder. @param wall  number of the rigid wall
  void move_wall(std::size_t wall, std::span<const double> displacement);

  // The following are collective.

  /// @throws ConvergenceError  soil or a surface moved beyond the search margin of begin_step
  /// @param largest  of SurplusMotions on this rank [m]
  void refuse_misses(double largest) const;
  /// Whether a contact looks ahead, so that refuse_misses has something to refuse.
  bool look_ahead() const;
  InterfaceValues forces_on_structure() const;
  /// Fill `interface_active` and the counts in `details`.
  void report(StepReport& report) const;
  /// Force on each rigid wall and moment about RigidWallSettings::moment_about, see
  /// ContactResults::resultant.
  std::vector<double> forces_on_walls() const;
  /// GroupContact::forces, none without groups. @note Not collective.
  std::vector<Vector<dim>> forces_between_groups() const;
  /// The smallest Contact::approach_step of all.
  double approach_step(double dt, double margin) const;
  /// Energies, summed over the contacts.
  ContactEnergy energy() const;
  /// Sum of ContactAssembly::step_force_on over the contacts, for the points of this rank [N].
  Vector<dim> step_force_on(std::span<const std::int64_t> ids) const;
  /// ContactState::fields of all ranks.
  ContactFields<dim> fields(std::size_t surface, const MaterialPoints<dim>& points,
                            double reach) const;

  /// ContactState::marks. @note Not collective.
  std::span<const ContactMark<dim>> marks(std::size_t surface) const {
    return contact_of(surface).state().marks(member_of(surface));
  }

  /// ContactState::accepted_vertices of a surface. @note Not collective.
  std::span<const Vector<dim>> accepted_vertices(std::size_t surface) const;

  /// ContactState::begin_at_rest of all of them.
  void begin_at_rest(const SoilAtRest<dim>& rest);
  void accept();
  /// ContactState::give and ContactState::take of all of them.
  void give(std::span<const std::int64_t> ids, Packet& packet);
  void take(Packet& packet);
  void visit_state(StateVisitor& visitor);

 private:
  /// Place of a surface among the contacts: number of the contact, and of the member in it.
  struct Place {
    std::size_t contact = 0, member = 0;
  };
  PlacedSurface<dim> placed(std::size_t surface) const;
  Contact<dim>& contact_of(std::size_t surface) const {
    return *contacts_[places_[surface].contact];
  }
  std::size_t member_of(std::size_t surface) const { return places_[surface].member; }
  void place(std::size_t surface, std::span<const double> displacement);
  std::vector<double> pool_forces_on(std::size_t surface) const;
  void drop(std::size_t surface);
  void take_back(std::size_t surface);
  ContactCounts counts(std::size_t surface) const;

  MPI_Comm comm_;
  const std::vector<ContactSettings<dim>>& interfaces_;
  const std::vector<RigidWallSettings<dim>>& walls_;
  std::vector<Place> places_;  // of each surface
  Contacts<dim> contacts_;
  const BodyGroups* groups_ = nullptr;           // null: all bodies share their nodes
  GroupContact<dim>* between_groups_ = nullptr;  // the last one of contacts_, with groups_
  std::vector<std::int32_t> dropped_;            // of each surface: 1 if it was
  std::vector<char> touching_;                   // of each surface, in this step, on any rank
  PoolLevels pools_;
  std::vector<std::vector<double>> displaced_;  // with pools: of the vertices of each surface
  bool symmetric_ = true;
};

}  // namespace gabion::mpm
