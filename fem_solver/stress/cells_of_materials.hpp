// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/mechanics/mesh/mesh.hpp"
#include "fem_solver/materials/cell_material.hpp"
#include "fem_solver/materials/line_material.hpp"
#include "fem_solver/ranks/mesh_ranks.hpp"

namespace gabion::fem {

/// Cells of each material, ascending: those of its group, or all where it has none.
/// @throws ConfigError  a group that the mesh does not have; a cell in none of the groups, or in
/// two
template <int dim>
std::vector<std::vector<std::int32_t>> cells_of_materials(
    const Mesh<dim>& mesh, std::span<const CellMaterial<dim>> materials, const MeshRanks& ranks);

/// Lines of the group of a material; none where the mesh lacks it, which lines_of_materials
/// refuses.
template <int dim>
std::span<const std::int32_t> lines_of(const Mesh<dim>& mesh, const LineMaterial& material) {
  const auto found = mesh.line_groups.find(material.group);
  if (found == mesh.line_groups.end()) return {};
  return found->second;
}

/// Lines of each material: those of its group.
/// @throws ConfigError  a group of lines that the mesh does not have; a line in two of the groups
template <int dim>
std::vector<std::vector<std::int32_t>> lines_of_materials(const Mesh<dim>& mesh,
                                                          std::span<const LineMaterial> materials,
                                                          const MeshRanks& ranks);

/// Number of a cell in the whole mesh, and its centre, for messages.
template <int dim>
std::string describe_cell(const Mesh<dim>& mesh, const MeshRanks& ranks, std::int32_t c);

/// Whether another rank may have a cell on the other side. @param facet  its corners
bool is_shared(std::span<const std::int32_t> facet, const SharedNodes& shared);

/// Refuse reduced hex20 in a row: a mode without energy, one of each cell, dies only where the cell
/// has neighbours along two axes, whatever holds the ends of the row.
/// @throws ConfigError  names the first such cell
template <int dim>
void refuse_loose_cells(const Mesh<dim>& mesh, std::span<const CellMaterial<dim>> materials,
                        const MeshRanks& ranks);

}  // namespace gabion::fem
