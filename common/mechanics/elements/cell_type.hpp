// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace gabion {

/// Shapes of cells and facets, all with linear or multilinear shape functions.
/// Node order: Gmsh's (counter-clockwise; hex8: bottom face, then top face).
/// Reference domains: line, quad and hex [-1, 1]^d; triangle and tetrahedron xi_i >= 0, sum <= 1.
enum class CellType { point1, line2, tri3, quad4, tet4, hex8 };

constexpr int num_nodes(CellType type) {
  switch (type) {
    case CellType::point1:
      return 1;
    case CellType::line2:
      return 2;
    case CellType::tri3:
      return 3;
    case CellType::quad4:
      return 4;
    case CellType::tet4:
      return 4;
    case CellType::hex8:
      return 8;
  }
  return 0;
}

constexpr int dimension(CellType type) {
  switch (type) {
    case CellType::point1:
      return 0;
    case CellType::line2:
      return 1;
    case CellType::tri3:
    case CellType::quad4:
      return 2;
    case CellType::tet4:
    case CellType::hex8:
      return 3;
  }
  return 0;
}

/// Shape of the facets of a cell: line2 for tri3 and quad4, tri3 for tet4, quad4 for hex8.
constexpr CellType facet_type(CellType type) {
  switch (type) {
    case CellType::tri3:
    case CellType::quad4:
      return CellType::line2;
    case CellType::tet4:
      return CellType::tri3;
    case CellType::hex8:
      return CellType::quad4;
    default:
      return CellType::point1;
  }
}

std::string name(CellType type);

/// Largest number of nodes of any cell.
inline constexpr int max_cell_nodes = 8;

}  // namespace gabion
