// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/mechanics/mesh/mesh.hpp"
#include "fem_solver/materials/line_material.hpp"
#include "fem_solver/ranks/mesh_ranks.hpp"

namespace gabion::fem {

/// Nodes of bars that lie inside cells and move with them (perfect bond): u = sum_a N_a(xi) u_a
/// over the nodes of the host cell, xi the place of the node before loading. They are no unknowns:
/// forces and masses of the lines go to the nodes of the host by the transpose of this sum.
template <int dim>
struct EmbeddedNodes {
  /// A node of the host and the value of its shape function.
  struct Share {
    std::int32_t node;
    double weight;
  };
  std::vector<std::int32_t> nodes;         ///< ascending
  std::vector<std::vector<Share>> shares;  ///< of each of them; the weights sum to 1

  /// Shares of any node: those of its host, or the node itself where it is not embedded.
  std::vector<Share> shares_of(std::int32_t node) const;
  bool contains(std::int32_t node) const;
  /// Share of node i in the displacement of a node.
  double weight(std::int32_t node, std::int32_t i) const;
  /// Let the embedded nodes follow their hosts, in displacements, velocities or accelerations.
  /// @param y  num_nodes x dim
  void follow(std::span<double> y) const;
  /// Nodes that a line of the mesh acts on, each once: its ends, or the nodes of their hosts.
  std::vector<std::int32_t> line_nodes(const Mesh<dim>& mesh, std::int32_t line) const;
};

/// Find the host of each node of lines with `embedded` that is not a node of a cell.
/// @throws ConfigError  a node outside all cells; one that is also of a line that is not embedded;
///                      several ranks
template <int dim>
EmbeddedNodes<dim> find_embedded_nodes(const Mesh<dim>& mesh,
                                       std::span<const LineMaterial> materials,
                                       const MeshRanks& ranks);

/// The mesh without lines that are embedded and without their nodes.
template <int dim>
Mesh<dim> without_embedded_lines(const Mesh<dim>& mesh, std::span<const LineMaterial> materials);

}  // namespace gabion::fem
