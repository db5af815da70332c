// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "tests/unit/mesh/mesh_checks.hpp"

namespace gabion::test_gmsh_reader {
namespace {

using test::enclosed_volume;
using test::resultant_area;
using test::total_volume;

const std::string data = MESH_DATA;

template <int dim>
void expect_equal(const Mesh<dim>& a, const Mesh<dim>& b) {
  EXPECT_EQ(a.cell_type, b.cell_type);
  EXPECT_EQ(a.cells, b.cells);
  EXPECT_EQ(a.facet_groups, b.facet_groups);
  EXPECT_EQ(a.cell_groups, b.cell_groups);
  ASSERT_EQ(a.nodes.size(), b.nodes.size());
  for (std::size_t i = 0; i < a.nodes.size(); ++i) {
    EXPECT_LT((a.nodes[i] - b.nodes[i]).norm(), 1e-15);  // Gmsh writes 16 digits as text
  }
}

TEST(GmshReader, text_and_binary_files_of_one_mesh_are_equal) {
  expect_equal(read_gmsh<2>(data + "/plate.msh"), read_gmsh<2>(data + "/plate_binary.msh"));
  expect_equal(read_gmsh<3>(data + "/bricks.msh"), read_gmsh<3>(data + "/bricks_binary.msh"));
  expect_equal(read_gmsh<3>(data + "/tetrahedra.msh"),
               read_gmsh<3>(data + "/tetrahedra_binary.msh"));
}

TEST(GmshReader, reads_a_triangle_mesh_with_groups) {
  const auto mesh = read_gmsh<2>(data + "/plate.msh");
  EXPECT_EQ(mesh.cell_type, CellType::tri3);
  EXPECT_NEAR(total_volume(mesh), enclosed_volume(mesh, boundary_facets(mesh)), 1e-14);
  EXPECT_GT(test::smallest_volume(mesh), 0.0);
  ASSERT_EQ(mesh.facet_groups.size(), 3u);
  EXPECT_NEAR(enclosed_volume(mesh, mesh.facets("outside", "")), 2.0, 1e-14);
  EXPECT_LT(resultant_area(mesh, mesh.facets("outside", "")).norm(), 1e-15);
  // The hole's facets point into the hole: away from the plate around it.
  const auto hole = facet_geometry<2>(mesh.nodes, CellType::line2, mesh.facets("hole", ""));
  for (std::size_t f = 0; f < hole.size(); ++f) {
    const Vector<2> at = mesh.nodes[mesh.facets("hole", "")[2 * f]];
    EXPECT_LT(hole[f].normal.dot(at - Vector<2>(1, 0.5)), 0.0);
  }
  // Between two cells the file's order is kept: the circle runs from (0.75, 0.5) to (1.25, 0.5).
  const auto& between = mesh.facets("between", "");
  EXPECT_EQ(mesh.nodes[between.front()], Vector<2>(0.75, 0.5));
  EXPECT_EQ(mesh.nodes[between.back()], Vector<2>(1.25, 0.5));
  EXPECT_EQ(mesh.cell_groups.at("plate").size() + mesh.cell_groups.at("inlay").size(),
            static_cast<std::size_t>(mesh.num_cells()));
}

TEST(GmshReader, reads_a_hex_mesh_with_groups) {
  const auto mesh = read_gmsh<3>(data + "/bricks.msh");
  EXPECT_EQ(mesh.cell_type, CellType::hex8);
  EXPECT_EQ(mesh.num_cells(), 12);
  EXPECT_NEAR(total_volume(mesh), 2.5 * 0.5, 1e-14);
  EXPECT_LT((resultant_area(mesh, mesh.facets("base", "")) - Vector<3>(0, 0, -2.5)).norm(), 1e-14);
  EXPECT_LT((resultant_area(mesh, mesh.facets("lid", "")) - Vector<3>(0, 0, 2.5)).norm(), 1e-14);
  EXPECT_NEAR(enclosed_volume(mesh, test::all_groups(mesh)), 1.25, 1e-14);
  EXPECT_EQ(mesh.cell_groups.at("block").size(), 12u);
}

TEST(GmshReader, reads_a_tet_mesh_and_names_a_nameless_group_by_its_number) {
  const auto mesh = read_gmsh<3>(data + "/tetrahedra.msh");
  EXPECT_EQ(mesh.cell_type, CellType::tet4);
  EXPECT_NEAR(total_volume(mesh), 2.0, 1e-14);
  EXPECT_NEAR(enclosed_volume(mesh, mesh.facets("all", "")), 2.0, 1e-14);
  EXPECT_EQ(mesh.facets("all", "").size(), boundary_facets(mesh).size());
  EXPECT_EQ(mesh.cell_groups.at("7").size(), static_cast<std::size_t>(mesh.num_cells()));
}

}  // namespace
}  // namespace gabion::test_gmsh_reader
