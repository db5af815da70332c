// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "common/mechanics/mesh/mesh.hpp"
#include "mpm_solver/grid/cell_locator.hpp"

namespace gabion::mpm {

/// A partition of the cells into patches of neighbours.
struct CellPatches {
  std::vector<std::int32_t> starts;    ///< first entry of each patch in `cells`, and their number
  std::vector<std::int32_t> cells;     ///< of the patches, ascending in each; patches by first cell
  std::vector<std::int32_t> first_of;  ///< first cell of the patch of each cell

  std::int32_t size() const {
    return starts.empty() ? 0 : static_cast<std::int32_t>(starts.size()) - 1;
  }
};

/// Join triangles to pairs and tetrahedra to bricks: a patch grows over its largest facets until it
/// has the nodes of a quadrilateral or a brick, and takes the cells that add no node. A mean volume
/// change for each patch then leaves a mesh of simplices as many constraints as one of
/// quadrilaterals or bricks has, two or three degrees of freedom for each. Cells that are left over
/// join a patch beside them. The box meshes give back their rectangles and bricks.
/// @see de Souza Neto, Andrade Pires, Owen (2005)
template <int dim>
CellPatches join_cells(const Mesh<dim>& mesh, const CellLocator<dim>& locator);

}  // namespace gabion::mpm
