// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <protocol/serve.hpp>

#include <array>
#include <span>

#include "elastic_solid.hpp"

namespace dealii_structure {

/// Boundary faces as vertices and linear facets. All nodes of a face are vertices: an edge of
/// degree p gives p segments, a face in 3D p x p quadrilaterals, with normals out of the solid. A
/// hanging node where a finer face meets a coarser one and the coarser one's own node there are one
/// vertex.
template <int dim>
class WetSurface {
 public:
  /// @throws gabion::ConfigError  a group that the mesh does not have
  WetSurface(const Settings& settings, const InterfaceSettings& interface,
             const ElasticSolid<dim>& solid);

  const gabion::InterfaceMesh& mesh() const { return mesh_; }
  /// Add forces [N] at the vertices to those at the nodes.
  void add_forces(std::span<const double> values, Vector& f) const;
  /// [m] at the vertices.
  std::vector<double> displacement(const Vector& u) const;

 private:
  gabion::InterfaceMesh mesh_;
  std::vector<std::array<unsigned, dim>> dofs_;  // of each vertex
};

}  // namespace dealii_structure
