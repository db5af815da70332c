// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace gabion {

/// Shapes of cells and facets: with linear or multilinear shape functions, and quadratic ones.
/// Node order: Gmsh's (corners counter-clockwise; hex8: bottom face, then top face; those of a
/// quadratic cell behind its corners: middle_nodes() in quadratic_cells.hpp).
/// Reference domains: line, quad and hex [-1, 1]^d; triangle and tetrahedron xi_i >= 0, sum <= 1.
enum class CellType {
  point1,
  line2,
  tri3,
  quad4,
  tet4,
  hex8,
  line3,
  tri6,
  quad8,
  quad9,
  tet10,
  hex20,
  hex27
};

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
    case CellType::line3:
      return 3;
    case CellType::tri6:
      return 6;
    case CellType::quad8:
      return 8;
    case CellType::quad9:
      return 9;
    case CellType::tet10:
      return 10;
    case CellType::hex20:
      return 20;
    case CellType::hex27:
      return 27;
  }
  return 0;
}

/// The linear cell on the corners of a cell.
constexpr CellType corner_type(CellType type) {
  switch (type) {
    case CellType::line3:
      return CellType::line2;
    case CellType::tri6:
      return CellType::tri3;
    case CellType::quad8:
    case CellType::quad9:
      return CellType::quad4;
    case CellType::tet10:
      return CellType::tet4;
    case CellType::hex20:
    case CellType::hex27:
      return CellType::hex8;
    default:
      return type;
  }
}

constexpr bool is_quadratic(CellType type) {
  return corner_type(type) != type;
}

constexpr int num_corners(CellType type) {
  return num_nodes(corner_type(type));
}

/// Whether it is a triangle or a tetrahedron.
constexpr bool is_simplex(CellType type) {
  return corner_type(type) == CellType::tri3 || corner_type(type) == CellType::tet4;
}

constexpr int dimension(CellType type) {
  switch (corner_type(type)) {
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
    default:
      return 0;
  }
}

/// Shape of the facets of a cell: line2 for tri3 and quad4, tri3 for tet4, quad4 for hex8; line3
/// for tri6, quad8 and quad9, tri6 for tet10, quad8 for hex20, quad9 for hex27.
constexpr CellType facet_type(CellType type) {
  switch (type) {
    case CellType::tri3:
    case CellType::quad4:
      return CellType::line2;
    case CellType::tet4:
      return CellType::tri3;
    case CellType::hex8:
      return CellType::quad4;
    case CellType::tri6:
    case CellType::quad8:
    case CellType::quad9:
      return CellType::line3;
    case CellType::tet10:
      return CellType::tri6;
    case CellType::hex20:
      return CellType::quad8;
    case CellType::hex27:
      return CellType::quad9;
    default:
      return CellType::point1;
  }
}

std::string name(CellType type);

/// Largest number of nodes of a linear cell; the cells of the soil's grid are linear.
inline constexpr int max_cell_nodes = 8;
/// Largest number of nodes of any cell, and of any facet.
inline constexpr int max_quadratic_nodes = 27;
inline constexpr int max_facet_nodes = 9;

}  // namespace gabion
