// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/run/solver.hpp"
#include "fem_solver/fem_config.hpp"
#include "fem_solver/step/structure_state.hpp"

namespace gabion::fem {

/// The wet surfaces of a structure, one an interface: facets of its mesh, vertices = nodes. They
/// take forces and give displacements.
template <int dim>
class WetSurfaces {
 public:
  /// @throws ConfigError  missing group, with those that exist
  WetSurfaces(const Mesh<dim>& structure, const std::vector<WetSurfaceSettings>& interfaces);

  /// Vertices in the order of their node numbers; facets with outward normals.
  const std::vector<InterfaceMesh>& meshes() const { return meshes_; }

  /// Which forces will be received; end of the step where nothing is said.
  /// @throws Error  unknown interface
  void set_force_kinds(const ForceKinds& kinds);

  /// Nodal forces of all interfaces; a node on two of them receives both.
  /// @returns empty when nothing was received
  /// @throws Error  unknown or missing interface, wrong number of values
  ExternalForces nodal_forces(const InterfaceValues& received) const;

  /// Total displacements of the vertices. @param u  num_nodes x dim [m]
  InterfaceValues displacements(std::span<const double> u) const;

 private:
  std::size_t num_dofs_;
  std::vector<InterfaceMesh> meshes_;
  std::vector<std::vector<std::int32_t>> nodes_;  // node of each vertex of each interface
  std::vector<ForceKind> kinds_;                  // of the forces received on each interface
};

}  // namespace gabion::fem
