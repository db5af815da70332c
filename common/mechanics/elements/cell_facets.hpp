// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "common/mechanics/elements/cell_type.hpp"

namespace gabion {

/// Number of facets: 3 of triangles, 4 of quads and tetrahedra, 6 of hexahedra.
constexpr int num_facets(CellType type) {
  switch (corner_type(type)) {
    case CellType::tri3:
      return 3;
    case CellType::quad4:
    case CellType::tet4:
      return 4;
    case CellType::hex8:
      return 6;
    default:
      return 0;
  }
}

/// Local nodes of facet `f` of a cell of positive volume, ordered so that the normal points out of
/// the cell (2D: direction turned clockwise; 3D: right-hand rule); corners first.
/// @pre type has facets, and 0 <= f < num_facets(type)
std::span<const int> facet_nodes(CellType type, int f);

/// Facet of a quad (dim 2) or hexahedron (dim 3) at xi_axis = -1 (end 0) or +1 (end 1).
constexpr int brick_facet(int dim, int axis, int end) {
  constexpr int facets[2][3][2] = {{{3, 1}, {0, 2}, {-1, -1}}, {{5, 3}, {2, 4}, {0, 1}}};
  return facets[dim - 2][axis][end];
}

}  // namespace gabion
