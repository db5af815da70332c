// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/mechanics/mesh/mesh.hpp"
#include "fem_solver/materials/cell_material.hpp"
#include "fem_solver/ranks/mesh_ranks.hpp"

namespace gabion::fem {

/// Crack bands of the cells of a material; empty when its law needs none.
/// @param ranks  for the number of a cell in messages
/// @throws ConfigError  a type of cells or a formulation within which cracks would localise; a cell
///                      too wide for the energies of its law
template <int dim>
std::vector<CrackBand<dim>> crack_bands(const Mesh<dim>& mesh, const CellMaterial<dim>& material,
                                        std::span<const std::int32_t> cells,
                                        const MeshRanks& ranks);

}  // namespace gabion::fem
