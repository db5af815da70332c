// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/mesh/mesh_checks.hpp"

namespace gabion::test_boundary {
namespace {

TEST(Boundary, neighbours_of_a_row_of_quads) {
  const auto mesh = box_mesh<2>({0, 0}, {3, 1}, {3, 1}, CellType::quad4);
  // Facets of a quad: bottom, right, top, left.
  EXPECT_EQ(cell_neighbours(mesh), (std::vector<std::int32_t>{-1, 1, -1, -1,  //
                                                              -1, 2, -1, 0,   //
                                                              -1, -1, -1, 1}));
}

/// Whether two triangles have the same nodes in opposite order.
template <class Facet>
bool are_turned_round(const Facet& a, const Facet& b) {
  for (int k = 0; k < 3; ++k) {
    if (b[k] == a[0] && b[(k + 2) % 3] == a[1] && b[(k + 1) % 3] == a[2]) return true;
  }
  return false;
}

TEST(Boundary, neighbours_are_mutual_and_share_the_facet_turned_round) {
  const auto mesh = box_mesh<3>({0, 0, 0}, {1, 1, 1}, {3, 2, 2}, CellType::tet4, true);
  const auto neighbours = cell_neighbours(mesh);
  int inner = 0;
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
    for (int f = 0; f < 4; ++f) {
      const std::int32_t other = neighbours[4 * c + f];
      if (other < 0) continue;
      ++inner;
      int shared = 0;
      for (int g = 0; g < 4; ++g) {
        if (neighbours[4 * other + g] != c) continue;
        shared += are_turned_round(cell_facet(mesh, c, f), cell_facet(mesh, other, g));
      }
      EXPECT_EQ(shared, 1);
    }
  }
  EXPECT_EQ(inner + static_cast<int>(boundary_facets(mesh).size()) / 3, 4 * mesh.num_cells());
}

TEST(Boundary, a_facet_of_three_cells_is_refused) {
  Mesh<2> mesh;
  mesh.nodes = {{0, 0}, {1, 0}, {0, 1}, {1, 1}, {0.5, 2}};
  mesh.cells = {0, 1, 2, 1, 3, 2, 1, 4, 2};
  EXPECT_EQ(test::error_of<ConfigError>([&] { cell_neighbours(mesh); }),
            "mesh: found 3 cells that share one facet of cell 0, allowed: at most two");
}

TEST(Boundary, normals_and_areas_of_a_deformed_surface) {
  const auto mesh = box_mesh<2>({0, 0}, {1, 1}, {1, 1}, CellType::quad4);
  auto x = mesh.nodes;
  const double angle = 0.3;  // turned and stretched twofold
  for (auto& p : x) {
    p = 2.0 * Vector<2>(std::cos(angle) * p[0] - std::sin(angle) * p[1],
                        std::sin(angle) * p[0] + std::cos(angle) * p[1]);
  }
  const auto right = facet_geometry<2>(x, CellType::line2, mesh.facets("right", ""));
  ASSERT_EQ(right.size(), 1u);
  EXPECT_NEAR(right[0].area, 2.0, 1e-15);
  EXPECT_LT((right[0].normal - Vector<2>(std::cos(angle), std::sin(angle))).norm(), 1e-15);
}

TEST(Boundary, area_vector_of_a_warped_quad_is_exact) {
  // The integral of n dA depends on the rim only: compare with the two triangles of either cut.
  const std::vector<Vector<3>> x = {{0, 0, 0}, {1, 0, 0.3}, {1.2, 1, -0.2}, {0, 1, 0.5}};
  const std::vector<std::int32_t> quad = {0, 1, 2, 3}, triangles = {0, 1, 2, 0, 2, 3};
  const auto whole = facet_area_vectors<3>(x, CellType::quad4, quad);
  const auto parts = facet_area_vectors<3>(x, CellType::tri3, triangles);
  EXPECT_LT((whole[0] - parts[0] - parts[1]).norm(), 1e-15);
}

TEST(Boundary, a_facet_without_area_is_refused) {
  const std::vector<Vector<2>> x = {{1, 1}, {1, 1}};
  const std::vector<std::int32_t> facets = {0, 1};
  test::expect_error<Error>([&] { facet_geometry<2>(x, CellType::line2, facets); },
                            {"facet 0 has no area"});
}

}  // namespace
}  // namespace gabion::test_boundary
