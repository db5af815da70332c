// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "common/run/solver.hpp"

namespace gabion::test {

/// Two sides of an interface "wall".
struct SurfacePair {
  InterfaceMesh structure;
  InterfaceMesh soil;
};

/// Segments through the places of these stations, in their order; the structure lies to their left.
inline InterfaceMesh line_mesh(const std::vector<double>& stations,
                               const std::function<std::pair<double, double>(double)>& place,
                               bool facets = true) {
  InterfaceMesh mesh;
  mesh.name = "wall";
  mesh.dim = 2;
  mesh.vertices_per_facet = facets ? 2 : 0;
  for (const double s : stations) {
    const auto [x, y] = place(s);
    mesh.coordinates.insert(mesh.coordinates.end(), {x, y});
  }
  for (std::int64_t i = 0; facets && i + 1 < std::ssize(stations); ++i) {
    mesh.facets.insert(mesh.facets.end(), {i, i + 1});
  }
  return mesh;
}

/// A surface of this height over the unit square, n x m quads or twice as many triangles.
inline InterfaceMesh sheet_mesh(int n, int m, int vertices_per_facet,
                                const std::function<double(double, double)>& height) {
  InterfaceMesh mesh;
  mesh.name = "wall";
  mesh.dim = 3;
  mesh.vertices_per_facet = vertices_per_facet;
  for (int j = 0; j <= m; ++j) {
    for (int i = 0; i <= n; ++i) {
      const double x = double(i) / n, y = double(j) / m;
      mesh.coordinates.insert(mesh.coordinates.end(), {x, y, height(x, y)});
    }
  }
  for (int j = 0; j < m; ++j) {
    for (int i = 0; i < n; ++i) {
      const std::int64_t a = j * (n + 1) + i, b = a + 1, c = b + n + 1, d = a + n + 1;
      if (vertices_per_facet == 4) mesh.facets.insert(mesh.facets.end(), {a, b, c, d});
      if (vertices_per_facet == 3) mesh.facets.insert(mesh.facets.end(), {a, b, c, a, c, d});
    }
  }
  return mesh;
}

}  // namespace gabion::test
