// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "tests/unit/mesh/mesh_checks.hpp"

namespace gabion::test_box_mesh {
namespace {

using test::enclosed_volume;
using test::error_of;
using test::resultant_area;
using test::total_volume;

struct BoxCase {
  CellType type;
  bool alternate;
  int cells_per_brick;
  double smallest_share;  // of the brick's volume
};

const BoxCase plane_cases[] = {{CellType::quad4, false, 1, 1.0},
                               {CellType::tri3, false, 2, 0.5},
                               {CellType::tri3, true, 2, 0.5}};
const BoxCase space_cases[] = {{CellType::hex8, false, 1, 1.0},
                               {CellType::tet4, false, 6, 1.0 / 6},
                               {CellType::tet4, true, 5, 1.0 / 6}};

template <int dim>
void check_box(const BoxCase& box, const Vector<dim>& low, const Vector<dim>& high,
               const Eigen::Matrix<int, dim, 1>& num_cells) {
  const auto mesh = box_mesh<dim>(low, high, num_cells, box.type, box.alternate);
  const double volume = (high - low).prod();
  const int bricks = num_cells.prod();
  EXPECT_EQ(mesh.num_cells(), bricks * box.cells_per_brick);
  EXPECT_EQ(mesh.num_nodes_total(), (num_cells.array() + 1).prod());
  EXPECT_EQ(mesh.nodes.front(), low);
  EXPECT_EQ(mesh.nodes.back(), high);
  EXPECT_NEAR(total_volume(mesh), volume, 1e-13 * volume);
  EXPECT_NEAR(test::smallest_volume(mesh), box.smallest_share * volume / bricks, 1e-13 * volume);

  // Conforming: cut faces of neighbours match, so nothing inside is a boundary.
  const auto outer = boundary_facets(mesh);
  EXPECT_EQ(outer.size(), test::all_groups(mesh).size());
  EXPECT_NEAR(enclosed_volume(mesh, outer), volume, 1e-13 * volume);
  EXPECT_NEAR(enclosed_volume(mesh, test::all_groups(mesh)), volume, 1e-13 * volume);
  EXPECT_TRUE(mesh.cell_groups.empty());
}

TEST(BoxMesh, of_the_plane_fills_the_box_conformingly) {
  for (const auto& box : plane_cases) {
    SCOPED_TRACE(name(box.type));
    check_box<2>(box, {-1.0, 2.0}, {2.0, 3.5}, {5, 4});
    check_box<2>(box, {0.1, 0.1}, {0.2, 0.7}, {1, 1});
  }
}

TEST(BoxMesh, of_space_fills_the_box_conformingly) {
  for (const auto& box : space_cases) {
    SCOPED_TRACE(name(box.type));
    check_box<3>(box, {-1.0, 2.0, 0.0}, {2.0, 3.5, 1.0}, {3, 4, 2});
    check_box<3>(box, {0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}, {1, 1, 1});
  }
}

TEST(BoxMesh, sides_face_their_way) {
  const Vector<2> low2(-1, 0), high2(3, 2);
  for (const auto& box : plane_cases) {
    const auto mesh = box_mesh<2>(low2, high2, {3, 5}, box.type, box.alternate);
    EXPECT_LT((resultant_area(mesh, mesh.facets("left", "")) - Vector<2>(-2, 0)).norm(), 1e-14);
    EXPECT_LT((resultant_area(mesh, mesh.facets("right", "")) - Vector<2>(2, 0)).norm(), 1e-14);
    EXPECT_LT((resultant_area(mesh, mesh.facets("bottom", "")) - Vector<2>(0, -4)).norm(), 1e-14);
    EXPECT_LT((resultant_area(mesh, mesh.facets("top", "")) - Vector<2>(0, 4)).norm(), 1e-14);
    EXPECT_EQ(mesh.facet_groups.size(), 4u);
  }
  for (const auto& box : space_cases) {
    const auto mesh = box_mesh<3>({0, 0, 0}, {1, 2, 3}, {2, 3, 2}, box.type, box.alternate);
    EXPECT_LT((resultant_area(mesh, mesh.facets("left", "")) - Vector<3>(-6, 0, 0)).norm(), 1e-14);
    EXPECT_LT((resultant_area(mesh, mesh.facets("right", "")) - Vector<3>(6, 0, 0)).norm(), 1e-14);
    EXPECT_LT((resultant_area(mesh, mesh.facets("front", "")) - Vector<3>(0, -3, 0)).norm(), 1e-14);
    EXPECT_LT((resultant_area(mesh, mesh.facets("back", "")) - Vector<3>(0, 3, 0)).norm(), 1e-14);
    EXPECT_LT((resultant_area(mesh, mesh.facets("bottom", "")) - Vector<3>(0, 0, -2)).norm(),
              1e-14);
    EXPECT_LT((resultant_area(mesh, mesh.facets("top", "")) - Vector<3>(0, 0, 2)).norm(), 1e-14);
    EXPECT_EQ(mesh.facet_groups.size(), 6u);
  }
}

TEST(BoxMesh, nodes_and_cells_run_along_x_first) {
  const auto mesh = box_mesh<2>({0, 0}, {2, 3}, {2, 3}, CellType::quad4);
  EXPECT_EQ(mesh.nodes[1], Vector<2>(1, 0));
  EXPECT_EQ(mesh.nodes[3], Vector<2>(0, 1));
  const auto cell = mesh.cell(3);
  EXPECT_EQ(std::vector<std::int32_t>(cell.begin(), cell.end()),
            (std::vector<std::int32_t>{4, 5, 8, 7}));
}

TEST(BoxMesh, alternate_turns_the_diagonal_of_every_second_rectangle) {
  const auto mesh = box_mesh<2>({0, 0}, {2, 1}, {2, 1}, CellType::tri3, true);
  EXPECT_EQ(mesh.cells, (std::vector<std::int32_t>{0, 1, 4, 0, 4, 3, 1, 2, 4, 2, 5, 4}));
}

TEST(BoxMesh, refuses_what_is_no_box) {
  EXPECT_EQ(error_of<ConfigError>([] {
              box_mesh<2>({0, 0}, {1, 0}, {1, 1}, CellType::quad4);
            }),
            "box mesh, axis 1: found low 0 and high 0, allowed: low < high");
  EXPECT_EQ(error_of<ConfigError>([] {
              box_mesh<2>({0, 0}, {1, 1}, {0, 1}, CellType::quad4);
            }),
            "box mesh, axis 0: found 0 cells, allowed: at least 1");
  EXPECT_EQ(error_of<ConfigError>([] {
              box_mesh<2>({0, 0}, {1, 1}, {1, 1}, CellType::hex8);
            }),
            "box mesh of dimension 2: found cell type hex8, allowed: tri3, quad4, tri6, quad8, "
            "quad9");
  EXPECT_EQ(error_of<ConfigError>([] {
              box_mesh<3>({0, 0, 0}, {1, 1, 1}, {10000, 10000, 10000}, CellType::hex8);
            }),
            "box mesh: found more cells than 32-bit indices can count");
}

TEST(Mesh, groups_are_found_by_name_or_refused_with_the_names_that_exist) {
  const auto mesh = box_mesh<2>({0, 0}, {1, 1}, {2, 2}, CellType::tri3);
  EXPECT_EQ(mesh.group_nodes("top", ""), (std::vector<std::int32_t>{6, 7, 8}));
  EXPECT_EQ(error_of<ConfigError>([&] { mesh.facets("lid", "a.json: at /x"); }),
            "a.json: at /x: found facet group \"lid\", the mesh has: bottom, left, right, top");
  EXPECT_EQ(error_of<ConfigError>([&] { Mesh<3>().group_nodes("lid", "here"); }),
            "here: found facet group \"lid\", the mesh has: none");
}

TEST(Mesh, cell_volume_of_a_general_quad_and_hex_is_exact) {
  Mesh<2> quad;
  quad.cell_type = CellType::quad4;
  quad.nodes = {{0, 0}, {2, 0.5}, {3, 2}, {-0.5, 1}};
  quad.cells = {0, 1, 2, 3};
  double shoelace = 0;
  for (int a = 0; a < 4; ++a) {
    const auto& p = quad.nodes[a];
    const auto& q = quad.nodes[(a + 1) % 4];
    shoelace += 0.5 * (p[0] * q[1] - p[1] * q[0]);
  }
  EXPECT_NEAR(cell_volume(quad, 0), shoelace, 1e-14);

  // Frustum: bottom 2 x 2, top 1 x 1, height 3.
  auto frustum = box_mesh<3>({-1, -1, 0}, {1, 1, 3}, {1, 1, 1}, CellType::hex8);
  for (auto& x : frustum.nodes) {
    if (x[2] > 0) x.head<2>() *= 0.5;
  }
  EXPECT_NEAR(cell_volume(frustum, 0), 3.0 / 3.0 * (4.0 + 1.0 + 2.0), 1e-13);
  std::swap(frustum.cells[1], frustum.cells[3]);
  std::swap(frustum.cells[5], frustum.cells[7]);
  EXPECT_NEAR(cell_volume(frustum, 0), -7.0, 1e-13);
}

}  // namespace
}  // namespace gabion::test_box_mesh
