// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>

#include "common/mechanics/elements/cell_type.hpp"
#include "common/mechanics/tensor.hpp"

namespace gabion {

/// A bit for each corner of a cell.
using CornerSet = std::uint8_t;

/// The nodes of a quadratic cell behind its corners, in Gmsh's order: each lies, in the reference
/// cell, in the mean of the corners in its set. Empty of linear cells.
std::span<const CornerSet> middle_nodes(CellType type);

/// Place of a node in the reference cell. @pre dimension(type) == dim
template <int dim>
Vector<dim> node_place(CellType type, int node);

/// Bring the nodes of a cell into the order of its mirror image: turns the sign of its volume.
void mirror_cell(CellType type, std::span<std::int32_t> nodes);

/// Linear facets on all nodes of a quadratic facet, in its sense of rotation: places of their nodes
/// among those of the facet, facets x linear_part_nodes(type). line3: 2 segments; tri6: 4
/// triangles; quad8: 6 triangles; quad9: 4 quads; a linear facet: itself.
std::span<const int> linear_parts(CellType facet_type);
/// Number of nodes of each of these linear facets.
int linear_part_nodes(CellType facet_type);

}  // namespace gabion
