// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/run/solver.hpp"
#include "fem_solver/fem_config.hpp"
#include "fem_solver/step/structure_state.hpp"
#include "fem_solver/stress/cell_integrals.hpp"

namespace gabion::fem {

/// Rotations of the nodes of beams in a state, in the order of their rotation nodes.
/// @param history  of the state
template <int dim>
std::vector<Matrix<dim>> beam_turns(const FemSettings<dim>& settings,
                                    const CellIntegrals<dim>& cells, std::span<const double> u,
                                    std::span<const double> history);

/// Continue the rotations with the spins of a motion.
/// @param v  of all nodes
template <int dim>
void turn_on(const FemSettings<dim>& settings, std::span<const double> v, double time,
             std::vector<Matrix<dim>>& turns);

/// Wet surfaces around beams: the outline of their section, drawn along them, with its ends. Points
/// of one section move with their node as a rigid body, p = x + R d, so forces on them are forces
/// and moments R d x f on the node (docs/theory/structure.md).
template <int dim>
class BeamSurfaces {
 public:
  /// Vertex on the section of a node.
  struct Vertex {
    std::int32_t place;     ///< node
    std::int32_t rotation;  ///< its rotation node
    Vector<dim> offset;     ///< d before loading [m]
  };

  /// Refers to the settings.
  /// @throws ConfigError  a group of no beams, beams that fork, beams against each other's
  ///                      direction, a section without shape
  explicit BeamSurfaces(const FemSettings<dim>& settings);

  const std::vector<InterfaceMesh>& meshes() const { return meshes_; }
  bool has(const std::string& name) const;
  void set_force_kind(const std::string& name, ForceKind kind);

  /// f += forces, and moments about the nodes over the length of rotations.
  /// @param turns  of beam_turns(), for the arms
  /// @throws Error  missing interface, wrong number of values
  void add_forces(const InterfaceValues& received, std::span<const Matrix<dim>> turns,
                  ExternalForces& forces) const;
  /// Displacements of the vertices.
  void add_displacements(std::span<const double> u, std::span<const Matrix<dim>> turns,
                         InterfaceValues& sent) const;

 private:
  const Matrix<dim>& turn_of(const Vertex& vertex, std::span<const Matrix<dim>> turns) const {
    return turns[vertex.rotation - settings_.num_places()];
  }

  const FemSettings<dim>& settings_;
  std::vector<InterfaceMesh> meshes_;
  std::vector<std::vector<Vertex>> vertices_;
  std::vector<ForceKind> kinds_;
};

}  // namespace gabion::fem
