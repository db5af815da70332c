// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/mechanics/mesh/mesh.hpp"
#include "common/mechanics/newton/newton.hpp"
#include "common/mechanics/petsc/linear_solver.hpp"
#include "common/mechanics/time_integration/newmark.hpp"
#include "common/settings/config_reader.hpp"
#include "common/settings/scene.hpp"
#include "common/settings/time_function.hpp"
#include "fem_solver/beams/beam_nodes.hpp"
#include "fem_solver/materials/cell_material.hpp"
#include "fem_solver/materials/line_material.hpp"
#include "fem_solver/materials/membrane_material.hpp"
#include "fem_solver/ranks/mesh_ranks.hpp"
#include "fem_solver/stress/embedded_nodes.hpp"

namespace gabion::fem {

/// Nodes of a facet group whose listed components do not move.
struct SupportSettings {
  std::string group;
  std::vector<int> components;   ///< 0 = x, 1 = y, 2 = z; all of them by default
  std::vector<int> rotations;    ///< of beams, about 0 = x, 1 = y, 2 = z; none by default
  bool report_reaction = false;  ///< adds probe columns reaction_<group>_x, ...
  bool report_moment = false;    ///< adds probe columns moment_<group>_z, in 3D _x, _y, _z
  std::string where;             ///< place in the config, for error messages
};

/// One displacement component of a group as a function of time.
struct PrescribedSettings {
  std::string group;
  int component = 0;
  TimeFunction displacement = TimeFunction::constant(0);  ///< [m]
  std::string where;
};

/// A force on the node at a point, or spread in equal parts over the nodes of a group.
template <int dim>
struct LoadSettings {
  std::optional<Vector<dim>> point;      ///< [m], reference configuration
  std::string group;                     ///< used when there is no point
  Vector<dim> force;                     ///< [N], in 2D per metre of thickness; the resultant
  Vector<3> moment = Vector<3>::Zero();  ///< on beams, about fixed axes [N m], likewise
  TimeFunction factor = TimeFunction::constant(1);
  std::string where;
};

/// A mass at a node, or spread in equal parts over the nodes of a group.
template <int dim>
struct PointMassSettings {
  std::optional<Vector<dim>> point;  ///< [m], reference configuration
  std::string group;                 ///< used when there is no point
  double mass = 0;                   ///< [kg], in 2D per metre of thickness; the sum
  std::string where;
};

/// A spring from a node to the ground, or in equal parts from the nodes of a group.
template <int dim>
struct SpringSettings {
  std::optional<Vector<dim>> point;  ///< [m], reference configuration
  std::string group;                 ///< used when there is no point
  Vector<dim> stiffness;             ///< along each axis [N/m], in 2D per metre; the sum
  std::string where;
};

/// A dashpot from a node to the ground, or in equal parts from the nodes of a group.
template <int dim>
struct DashpotSettings {
  std::optional<Vector<dim>> point;  ///< [m], reference configuration
  std::string group;                 ///< used when there is no point
  Vector<dim> damping;               ///< along each axis [N s/m], in 2D per metre; the sum
  std::string where;
};

/// Nodes of a group that move with a node of beams as a rigid body.
struct RigidLinkSettings {
  std::string beam;   ///< group of the one node of beams
  std::string group;  ///< of facets or points
  std::string where;  ///< place in the config, for error messages
};

/// A dead load per reference area.
template <int dim>
struct TractionSettings {
  std::string group;
  Vector<dim> traction;  ///< [Pa]
  TimeFunction factor = TimeFunction::constant(1);
  std::string where;
};

/// A coupled wet surface: the facets of these groups.
struct WetSurfaceSettings {
  std::string name;
  std::vector<std::string> groups;
  std::string where;
  /// Groups of cells that leave the surface when they are gone, and open what is behind them.
  std::vector<std::string> behind = {};
  std::string behind_where = {};
};

/// A coupled wet surface around the beams of these groups of lines.
struct BeamSurfaceSettings {
  std::string name;
  std::vector<std::string> groups;
  std::string where;
};

/// A point whose displacement is reported.
template <int dim>
struct ProbeSettings {
  std::string name;
  Vector<dim> point;  ///< [m], reference configuration
  std::string where;
};

/// A plane on which force and moment between the parts of a structure are reported.
template <int dim>
struct SectionSettings {
  std::string name;
  Vector<dim> point;   ///< [m], reference configuration
  Vector<dim> normal;  ///< of length 1
  std::string where;
};

/// Settings of the start and the motion of a structure, whatever it is made of.
template <int dim>
struct MotionSettings {
  bool dynamic = true;  ///< false: inertia is left out
  NewmarkBossak time_integration;
  Vector<dim> initial_velocity = Vector<dim>::Zero();  ///< [m/s], of all free components
  bool initial_equilibrium = false;  ///< start at rest under gravity and the loads at time 0
};

inline constexpr NewtonSettings newton_defaults{.reuse_matrix = true};

/// fem.json of a structure with a mesh.
template <int dim>
struct FemSettings : MotionSettings<dim> {
  Mesh<dim> mesh;                            ///< the part of this rank
  MeshRanks ranks;                           ///< how it lies in the whole
  std::vector<CellMaterial<dim>> materials;  ///< of all cells, or each of a group of cells
  std::vector<LineMaterial> line_materials;  ///< each of a group of lines
  std::vector<MembraneMaterial> membranes;   ///< each of a group of facets
  EmbeddedNodes<dim> embedded;               ///< nodes of lines inside cells
  /// The mesh has nodes of rotations behind its places, see BeamNodes.
  std::vector<std::int32_t> rotation_nodes;
  double rotation_length = 1;                 ///< [m]
  bool lumped_mass = false;                   ///< row sums instead of the consistent mass matrix
  Vector<dim> gravity = Vector<dim>::Zero();  ///< [m/s^2]
  std::vector<SupportSettings> supports;
  std::vector<PrescribedSettings> prescribed;
  std::vector<LoadSettings<dim>> loads;
  std::vector<PointMassSettings<dim>> point_masses;
  std::vector<SpringSettings<dim>> springs;
  std::vector<DashpotSettings<dim>> dashpots;
  std::vector<TractionSettings<dim>> tractions;
  std::vector<RigidLinkSettings> rigid_links;
  std::vector<WetSurfaceSettings> interfaces;
  std::vector<BeamSurfaceSettings> beam_surfaces;
  bool coupled() const { return !interfaces.empty() || !beam_surfaces.empty(); }
  std::vector<ProbeSettings<dim>> probes;
  std::vector<SectionSettings<dim>> sections;
  BeamNodes beam_nodes() const { return {rotation_nodes, rotation_length}; }
  /// Number of nodes without those of rotations.
  std::int32_t num_places() const {
    return rotation_nodes.empty() ? mesh.num_nodes_total()
                                  : static_cast<std::int32_t>(rotation_nodes.size());
  }
  NewtonSettings newton = newton_defaults;
  LinearSolverSettings linear_solver;
};

/// Names of the components in config files and probe columns.
inline constexpr const char* component_names[3] = {"x", "y", "z"};

/// Keys of fem.json.
KeyTable fem_keys();

KeyTable section_keys();

/// "dimension": 2 or 3.
int read_dimension(ConfigReader& in);

// Readers of parts that every structure has.

template <int dim>
void read_motion(ConfigReader& in, MotionSettings<dim>& s);
/// @param surface  the key of the facets, "groups" or "facets"
WetSurfaceSettings read_interface(ConfigReader in, const std::string& surface);
template <int dim>
std::vector<ProbeSettings<dim>> read_probes(ConfigReader& in);
template <int dim>
std::vector<SectionSettings<dim>> read_sections(ConfigReader& in);

/// @throws ConfigError  damping in statics, or of a coupled structure with another scheme than the
///                      trapezoidal rule
template <int dim>
void check_damping(const FemSettings<dim>& s);

/// @throws ConfigError  two of a list have the same name
template <class List>
void require_distinct_names(const ConfigReader& in, const std::string& key, const List& list) {
  std::set<std::string> names;
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (names.insert(list[i].name).second) continue;
    in.fail(fmt::format("{}/{}/name", key, i),
            fmt::format("found \"{}\" a second time, allowed: distinct names", list[i].name));
  }
}

/// Read all of fem.json (fem_keys()) except "dimension", "time" and "output".
/// @param comm  the ranks that divide the mesh; MPI_COMM_NULL: this process has all of it
/// @throws ConfigError  contradictory settings, wrong keys and values
/// @note Collective.
template <int dim>
FemSettings<dim> read_fem_settings(const Scene& scene, ConfigReader& in,
                                   MPI_Comm comm = MPI_COMM_NULL);

}  // namespace gabion::fem
