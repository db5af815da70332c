// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/mechanics/mesh/mesh.hpp"
#include "fem_solver/materials/cell_material.hpp"
#include "fem_solver/ranks/mesh_ranks.hpp"

namespace gabion::fem {

/// Reference axis of each cell along the thickness of the shell, as the material says.
/// @throws ConfigError  a cell where that is not clear; names it and what to set
std::vector<int> thickness_axes(const Mesh<3>& mesh, const CellMaterial<3>& material,
                                std::span<const std::int32_t> cells, const MeshRanks& ranks);

}  // namespace gabion::fem
