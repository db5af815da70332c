// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "common/mechanics/mesh/surface_mesh.hpp"
#include "tests/support/gmsh_text.hpp"
#include "tests/unit/mesh/mesh_checks.hpp"

namespace gabion::test::test_surface_meshes {
namespace {

/// The tower with ropes from its head, node 6, to an anchor: curves of the same mesh.
GmshText guyed() {
  GmshText file = tower();
  file.groups.push_back({1, 4, "ropes"});
  file.entities.push_back({1, 3, {4}});
  file.nodes.insert(file.nodes.begin() + 4, {-2, 0, 0});  // between nodes of cells
  file.blocks = {{1, 1, 1, {{1, 2}}},
                 {1, 2, 1, {{6, 7}}},
                 {1, 3, 1, {{7, 5}, {4, 5}}},
                 {2, 1, 3, {{1, 2, 3, 4}, {4, 3, 6, 7}}}};
  return file;
}

/// A brick with its side "wall", and a net of one mesh, "net", beside it with its ropes.
GmshText brick_with_net() {
  return {.groups = {{2, 1, "wall"}, {2, 2, "net"}, {3, 3, "body"}, {1, 4, "ropes"}},
          .entities = {{1, 1, {4}}, {2, 1, {1}}, {2, 2, {2}}, {3, 1, {3}}},
          .nodes = {{0, 0, 0},
                    {1, 0, 0},
                    {1, 1, 0},
                    {0, 1, 0},
                    {0, 0, 1},
                    {1, 0, 1},
                    {1, 1, 1},
                    {0, 1, 1},
                    {2, 1, 0},
                    {2, 1, 1}},
          .blocks = {{1, 1, 1, {{3, 9}, {9, 10}, {10, 7}}},
                     {2, 1, 3, {{2, 6, 7, 3}}},
                     {2, 2, 3, {{3, 9, 10, 7}}},
                     {3, 1, 5, {{1, 2, 3, 4, 5, 6, 7, 8}}}}};
}

TEST(SurfaceMeshes, ropes_in_the_plane_are_left_out) {
  const TemporaryMesh file(guyed());
  const auto mesh = read_gmsh_surface<2>(file.path(), {"top"}), alone = read_text<2>(tower());
  EXPECT_EQ(mesh.nodes, alone.nodes);
  EXPECT_EQ(mesh.cells, alone.cells);
  EXPECT_EQ(mesh.facet_groups, alone.facet_groups);
  EXPECT_EQ(mesh.cell_groups, alone.cell_groups);
}

TEST(SurfaceMeshes, meshes_of_a_net_are_left_out) {
  const TemporaryMesh file(brick_with_net());
  const auto mesh = read_gmsh_surface<3>(file.path(), {"wall"});
  EXPECT_EQ(mesh.num_nodes_total(), 8);
  ASSERT_EQ(mesh.facet_groups.size(), 1u);
  EXPECT_EQ(resultant_area(mesh, mesh.facets("wall", "")), Vector<3>(1, 0, 0));
}

TEST(SurfaceMeshes, groups_that_are_named_need_cells) {
  const TemporaryMesh ropes(guyed(), 1), net(brick_with_net(), 2);
  expect_error<ConfigError>(
      [&] {
        read_gmsh_surface<2>(ropes.path(), {"top", "ropes"});
      },
      {"found a facet of group \"ropes\" (nodes 7, 5)", "to no cell"});
  expect_error<ConfigError>([&] { read_gmsh_surface<3>(net.path(), {"net"}); },
                            {"found a facet of group \"net\" (nodes 3, 9, 10, 7)", "to no cell"});
  expect_error<ConfigError>([&] { read_gmsh<2>(ropes.path()); }, {"\"ropes\"", "to no cell"});
}

/// A group with facets of a cell and others keeps the first; another name of them is not "ropes".
TEST(SurfaceMeshes, facets_of_cells_stay_in_groups_that_nobody_names) {
  GmshText text = guyed();
  text.blocks[2].elements.push_back({3, 6});
  const TemporaryMesh file(text);
  const auto mesh = read_gmsh_surface<2>(file.path(), {"foot"});
  EXPECT_EQ(mesh.facets("ropes", "").size(), 2u);
  expect_error<ConfigError>([&] { mesh.facets("rope", "here"); },
                            {"here: found facet group \"rope\"", "foot, ropes, top"});
}

}  // namespace
}  // namespace gabion::test::test_surface_meshes
