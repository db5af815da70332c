// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include "mpm_solver/contact/contact.hpp"

namespace gabion::mpm {

/// All surfaces that may touch the soil: the interfaces, then the rigid walls. Refers to their
/// settings.
template <int dim>
class Surfaces {
 public:
  Surfaces(const std::vector<ContactSettings<dim>>& interfaces,
           const std::vector<RigidWallSettings<dim>>& walls);

  const Contacts<dim>& contacts() const { return contacts_; }
  std::vector<InterfaceMesh> interface_meshes() const;

  void begin_step(const SoilSurface<dim>& soil);
  /// Whether the stiffness of this step is symmetric.
  bool symmetric() const;
  /// Give the interfaces their displacements, 0 to those that received none.
  void receive(const InterfaceValues& displacements);
  /// Move the rigid walls to where they are at a time [s].
  void move_walls(double time);

  InterfaceValues forces_on_structure() const;
  /// Fill `interface_active` and the counts in `details`.
  void report(StepReport& report) const;
  /// Force and moment of each rigid wall, see Contact::resultant. @note Collective.
  std::vector<double> forces_on_walls(MPI_Comm comm) const;
  /// The smallest Contact::approach_step of all. @note Collective.
  double approach_step(MPI_Comm comm, double dt, double margin) const;

  void accept();
  void visit_state(StateVisitor& visitor);

 private:
  const std::vector<ContactSettings<dim>>& interfaces_;
  const std::vector<RigidWallSettings<dim>>& walls_;
  Contacts<dim> contacts_;
};

}  // namespace gabion::mpm
