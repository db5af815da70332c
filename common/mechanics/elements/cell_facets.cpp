// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/elements/cell_facets.hpp"

#include <cassert>

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

}  // namespace

std::span<const int> facet_nodes(CellType type, int f) {
  const int* table = facet_table(type);
  assert(table != nullptr && f >= 0 && f < num_facets(type));
  const int n = num_nodes(facet_type(type));
  return {table + f * n, static_cast<std::size_t>(n)};
}

}  // namespace gabion
