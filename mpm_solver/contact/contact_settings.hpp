// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "common/mechanics/mesh/mesh.hpp"
#include "common/run/solver.hpp"
#include "mpm_solver/contact/contact_law.hpp"
#include "mpm_solver/contact/rigid_motion.hpp"

namespace gabion::mpm {

/// The soil's copy of a structure's surface.
template <int dim>
struct ContactSurface {
  std::vector<Vector<dim>> vertices;  ///< [m], reference configuration
  CellType facet_type = CellType::line2;
  std::vector<std::int32_t> facets;  ///< normals point out of the structure, into the soil
};

/// Quantity that the penalty of boundary points acts on.
enum class GapMemory {
  accumulated,  ///< gap since soil came into the point's cell: force independent of the step size
  step,         ///< displacement of this step only: the force depends on the step size
};

/// The settings of the method `boundary_points`.
struct BoundaryPointSettings {
  double penalty = 0;           ///< [Pa/m]
  double tangential_share = 1;  ///< of the penalty in tangential directions, in (0, 1]
  GapMemory memory = GapMemory::accumulated;
  int points_per_facet = 2;
};

/// Settings of the method `facets`; M is the P-wave modulus of the body in contact, h the mean cell
/// size.
struct FacetSettings {
  double penalty_factor = 10;  ///< traction at a depth d: penalty_factor M (d / h)^2
  /// Factor of contacts that begin while soil takes its weight: above the pressure p_0 at the
  /// bottom of the body the stiffness is resting_factor M / h, up to p_0 the traction is that
  /// factor squared times M^2 / (4 p_0) (d / h)^2; 0: these contacts are like others.
  double resting_factor = 0;
  double tangential_factor = 0.25;  ///< stiffness: tangential_factor M / h
};

/// Settings that all methods of contact share, and those of one of them.
template <int dim>
struct ContactSettings {
  std::string name;   ///< of the interface or the wall
  std::string where;  ///< place of the surface in the config, for messages
  ContactSurface<dim> surface;
  ContactMode mode = ContactMode::contact;
  double friction = -1;      ///< as in ContactLaw
  double drag = 0;           ///< as in ContactLaw, of facets [Pa s^2/m^2]
  FrictionFall weakening{};  ///< of the friction, of facets
  bool drained = false;      ///< pore water of soil in contact with it leaves as into air
  std::variant<BoundaryPointSettings, FacetSettings> method;
};

/// A surface at rest or with a given motion, whatever the soil does.
template <int dim>
struct RigidWallSettings {
  std::string name;
  ContactSettings<dim> boundary;
  RigidMotion<dim> motion;
  bool is_boulder = false;                         ///< it moves as a boulder does, not as given
  Vector<dim> moment_about = Vector<dim>::Zero();  ///< place of the moment that is reported [m]
};

/// The surface as the coupler sees it.
template <int dim>
InterfaceMesh interface_mesh(const ContactSettings<dim>& settings);

}  // namespace gabion::mpm
