// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/mechanics/mesh/mesh.hpp"

namespace gabion::fem {

/// Wet facets of a structure whose cells leave it. A facet goes with its cell; where a cell is gone
/// to which soil comes, the faces of the cells that remain behind it are wet. Soil comes to cells
/// with a wet facet of the beginning, and from there through faces between cells that are gone.
template <int dim>
class ExposedFacets {
 public:
  /// Refers to the mesh, of linear cells.
  /// @param facets  wet ones at the beginning, by the nodes of the mesh
  /// @param leaving cells that may leave the surface, ascending; all others keep their facets
  ExposedFacets(const Mesh<dim>& mesh, std::span<const std::int64_t> facets,
                std::span<const std::int32_t> leaving);

  /// The cell of each facet of the beginning that may leave, -1: it stays whatever happens.
  const std::vector<std::int32_t>& cells() const { return cells_; }
  /// Facets by the nodes of the mesh, normals out of the structure: those of the beginning that are
  /// left, in their order, then those that came free, cell by cell.
  /// @param gone  1 for each cell of the mesh that left the structure
  std::vector<std::int64_t> facets(std::span<const char> gone) const;

 private:
  std::vector<std::int32_t> open_cells(std::span<const char> gone) const;
  bool has_left(std::int32_t cell, std::span<const char> gone) const {
    return cell >= 0 && leaving_[cell] != 0 && gone[cell] != 0;
  }

  const Mesh<dim>& mesh_;
  std::vector<std::int64_t> facets_;
  std::vector<std::int32_t> cells_;       // of each facet
  std::vector<char> leaving_;             // of each cell
  std::vector<std::int32_t> neighbours_;  // of each cell, by its faces
};

}  // namespace gabion::fem
