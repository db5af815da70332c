// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/mechanics/mesh/mesh.hpp"
#include "fem_solver/materials/cell_material.hpp"
#include "fem_solver/ranks/mesh_ranks.hpp"
#include "fem_solver/stress/enhanced_strain.hpp"
#include "fem_solver/stress/shell_strain.hpp"

namespace gabion::fem {

/// What is computed once of the cells of a block.
template <int dim>
struct CellGeometry {
  int points_per_cell = 0;
  std::vector<Vector<dim>> gradients;   ///< dN/dx, cells x points x nodes
  std::vector<double> weights;          ///< cells x points [m^dim]
  std::vector<ModeStrains<dim>> modes;  ///< cells x points; empty: not enhanced, or shells
  ShellCells shells;
};

/// @param cells  of the mesh
/// @param ranks  for the number of a cell in messages
/// @throws ConfigError  a cell with a Jacobian <= 0 at a quadrature point; see thickness_axes()
template <int dim>
CellGeometry<dim> cell_geometry(const Mesh<dim>& mesh, const CellMaterial<dim>& material,
                                std::span<const std::int32_t> cells, const MeshRanks& ranks);

}  // namespace gabion::fem
