// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/mechanics/mesh/mesh.hpp"

namespace gabion {

/// The cells that each facet belongs to; facets are found by their corners, in any order.
class FacetOwners {
 public:
  struct Owner {
    std::int32_t cell;
    int facet;  ///< local number, see `facet_nodes`
  };

  template <int dim>
  explicit FacetOwners(const Mesh<dim>& mesh);

  /// Owners of the facet with these nodes, corners first: none, one (outer facet) or two, lower
  /// cell first; none of one with another number of nodes than the facets of the cells.
  std::span<const Owner> find(std::span<const std::int32_t> nodes) const;

  /// Visit the owners of each facet that has several, one facet after the other: visit(span).
  template <class Visit>
  void for_each_shared(const Visit& visit) const {
    for (std::size_t first = 0, last = 0; first < keys_.size(); first = last) {
      while (last < keys_.size() && keys_[last] == keys_[first]) ++last;
      if (last - first > 1) visit(std::span(owners_).subspan(first, last - first));
    }
  }

 private:
  using Key = std::array<std::int32_t, 4>;  // sorted; unused places hold the largest number
  Key key(std::span<const std::int32_t> nodes) const;

  std::size_t num_nodes_ = 0, num_corners_ = 0;  // of a facet
  std::vector<Key> keys_;                        // sorted, one per owner
  std::vector<Owner> owners_;
};

/// Nodes of facet `f` of cell `c`, normal outward; the first num_nodes(facet_type) entries count.
template <int dim>
std::array<std::int32_t, max_facet_nodes> cell_facet(const Mesh<dim>& mesh, std::int32_t c, int f);

/// The cell on the other side of each facet, num_cells x num_facets(cell_type); -1 outside.
/// @throws ConfigError  a facet that belongs to more than two cells
template <int dim>
std::vector<std::int32_t> cell_neighbours(const Mesh<dim>& mesh);

/// All facets that belong to one cell only, num_facets x num_nodes(facet_type), normals outward,
/// in the order of the cells.
template <int dim>
std::vector<std::int32_t> boundary_facets(const Mesh<dim>& mesh);

/// Area vectors [m^(dim-1)] of facets, normal times area, for nodes at `x`: exact integral of
/// n dA, also over a warped quad. @param facets  num_facets x num_nodes(type), linear ones
template <int dim>
std::vector<Vector<dim>> facet_area_vectors(std::span<const Vector<dim>> x, CellType type,
                                            std::span<const std::int32_t> facets);

/// Normal of length 1 and area of a facet; of a warped quad the mean normal and the area
/// projected on it.
template <int dim>
struct FacetGeometry {
  Vector<dim> normal;
  double area;  ///< [m^(dim-1)]
};

/// @throws Error  facet without area, names its number
template <int dim>
std::vector<FacetGeometry<dim>> facet_geometry(std::span<const Vector<dim>> x, CellType type,
                                               std::span<const std::int32_t> facets);

}  // namespace gabion
