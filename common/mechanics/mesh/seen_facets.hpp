// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <set>
#include <span>
#include <vector>

#include "common/mechanics/tensor.hpp"

namespace gabion {

/// Facets that were seen, told apart by the positions of their vertices and by their side.
template <int dim>
class SeenFacets {
 public:
  /// @param nodes  positions [m]
  /// @param facet  its vertices among them
  /// @return whether it is new
  bool add(std::span<const Vector<dim>> nodes, std::span<const std::int32_t> facet) {
    std::vector<std::array<double, dim>> vertices(facet.size());
    for (std::size_t a = 0; a < facet.size(); ++a) {
      std::copy_n(nodes[facet[a]].data(), dim, vertices[a].begin());
    }
    // In 3D any vertex may come first; their sense of rotation is the side.
    if constexpr (dim == 3) {
      std::rotate(vertices.begin(), std::min_element(vertices.begin(), vertices.end()),
                  vertices.end());
    }
    return facets_.insert(std::move(vertices)).second;
  }

 private:
  std::set<std::vector<std::array<double, dim>>> facets_;
};

}  // namespace gabion
