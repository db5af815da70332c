// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/elements/cell_facets.hpp"

#include <algorithm>
#include <cassert>
#include <vector>

#include "common/mechanics/elements/quadratic_cells.hpp"

namespace gabion {

namespace {

constexpr int tri3_facets[] = {0, 1, 1, 2, 2, 0};
constexpr int quad4_facets[] = {0, 1, 1, 2, 2, 3, 3, 0};
constexpr int tet4_facets[] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
constexpr int hex8_facets[] = {0, 3, 2, 1, 4, 5, 6, 7, 0, 1, 5, 4,
                               1, 2, 6, 5, 2, 3, 7, 6, 3, 0, 4, 7};

const int* facet_table(CellType type) {
  switch (type) {
    case CellType::tri3:
      return tri3_facets;
    case CellType::quad4:
      return quad4_facets;
    case CellType::tet4:
      return tet4_facets;
    case CellType::hex8:
      return hex8_facets;
    default:
      return nullptr;
  }
}

std::vector<int> quadratic_facets(CellType type) {
  const CellType facet = facet_type(type);
  const auto own = middle_nodes(type);
  std::vector<int> table;
  for (int f = 0; f < num_facets(type); ++f) {
    const auto corners = facet_nodes(corner_type(type), f);
    table.insert(table.end(), corners.begin(), corners.end());
    for (const CornerSet of_facet : middle_nodes(facet)) {
      CornerSet wanted = 0;
      for (std::size_t a = 0; a < corners.size(); ++a) {
        if (of_facet >> a & 1) wanted |= static_cast<CornerSet>(1 << corners[a]);
      }
      const auto found = std::ranges::find(own, wanted);
      assert(found != own.end());
      table.push_back(num_corners(type) + static_cast<int>(found - own.begin()));
    }
  }
  return table;
}

const int* quadratic_facet_table(CellType type) {
  static const std::vector<int> tables[] = {
      quadratic_facets(CellType::tri6),  quadratic_facets(CellType::quad8),
      quadratic_facets(CellType::quad9), quadratic_facets(CellType::tet10),
      quadratic_facets(CellType::hex20), quadratic_facets(CellType::hex27)};
  return tables[static_cast<int>(type) - static_cast<int>(CellType::tri6)].data();
}

}  // namespace

std::span<const int> facet_nodes(CellType type, int f) {
  const int* table = is_quadratic(type) ? quadratic_facet_table(type) : facet_table(type);
  assert(table != nullptr && f >= 0 && f < num_facets(type));
  const int n = num_nodes(facet_type(type));
  return {table + f * n, static_cast<std::size_t>(n)};
}

}  // namespace gabion
