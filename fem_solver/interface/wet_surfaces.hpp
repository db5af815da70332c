// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/run/solver.hpp"
#include "fem_solver/fem_config.hpp"
#include "fem_solver/step/structure_state.hpp"

namespace gabion::fem {

/// Facets of an interface, group by group, by the nodes of a mesh: on one rank all of them.
/// @throws ConfigError  missing group, with those that exist
template <int dim>
std::vector<std::int64_t> facets_of(const Mesh<dim>& mesh, const WetSurfaceSettings& interface);

/// The wet surfaces of a structure, one an interface: facets of its mesh, vertices = nodes;
/// those of cells behind them (WetSurfaceSettings::behind) too. Quadratic facets are split into
/// linear ones on all of their nodes, linear_parts(). They take forces and give displacements. Each
/// rank has all of the surfaces, and the nodal vectors of the nodes that it holds.
template <int dim>
class WetSurfaces {
 public:
  /// @param structure     the part of this rank
  /// @throws ConfigError  missing group, with those that exist
  /// @note Collective.
  WetSurfaces(const Mesh<dim>& structure, const std::vector<WetSurfaceSettings>& interfaces,
              const MeshRanks& ranks = {});

  /// Vertices in the order of their node numbers; facets with outward normals.
  const std::vector<InterfaceMesh>& meshes() const { return meshes_; }

  /// Nodes of the vertices of an interface that this rank holds, -1: it does not.
  std::span<const std::int32_t> nodes(std::size_t interface) const { return nodes_[interface]; }

  /// Set the kind of the forces that each interface will receive; by default those at the end of
  /// the step.
  /// @throws Error  unknown interface
  void set_force_kinds(const ForceKinds& kinds);

  /// Nodal forces of all interfaces; a node on two of them receives both.
  /// @returns empty when nothing was received
  /// @throws Error  unknown or missing interface, wrong number of values
  ExternalForces nodal_forces(const InterfaceValues& received) const;

  /// Total displacements of the vertices. @param u  num_nodes x dim [m]
  /// @note Collective.
  InterfaceValues displacements(std::span<const double> u) const;

 private:
  template <class Values>
  std::vector<double> of_vertices(std::span<const std::int32_t> nodes, const Values& of_node) const;

  SharedNodes shared_;
  std::size_t num_dofs_;
  std::vector<InterfaceMesh> meshes_;
  std::vector<std::vector<std::int32_t>> nodes_;  // of each vertex of each interface; -1: not held
  std::vector<ForceKind> kinds_;                  // of the forces received on each interface
};

}  // namespace gabion::fem
