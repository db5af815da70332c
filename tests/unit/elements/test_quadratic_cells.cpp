// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "common/mechanics/elements/cell_facets.hpp"
#include "common/mechanics/elements/quadratic_cells.hpp"
#include "common/mechanics/elements/shape_functions.hpp"
#include "common/mechanics/mesh/boundary.hpp"
#include "common/mechanics/mesh/mesh.hpp"

namespace gabion::test::test_quadratic_cells {
namespace {

constexpr CellType plane_cells[] = {CellType::tri6, CellType::quad8, CellType::quad9};
constexpr CellType space_cells[] = {CellType::tet10, CellType::hex20, CellType::hex27};

template <int dim>
void expect_nodal_shapes(CellType type) {
  AnyShapeValues<dim> at_node;
  for (int b = 0; b < num_nodes(type); ++b) {
    shape_functions<dim>(type, node_place<dim>(type, b), at_node);
    for (int a = 0; a < num_nodes(type); ++a) {
      EXPECT_NEAR(at_node.N[a], a == b ? 1 : 0, 1e-15) << name(type) << a << " " << b;
    }
  }
}

template <int dim>
void expect_derivatives(CellType type) {
  const Vector<dim> xi = Vector<dim>::LinSpaced(0.13, 0.31);
  const double h = 1e-6;
  AnyShapeValues<dim> shape, plus, minus;
  shape_functions<dim>(type, xi, shape);
  double sum = 0;
  for (int a = 0; a < num_nodes(type); ++a) sum += shape.N[a];
  EXPECT_NEAR(sum, 1, 1e-15) << name(type);
  for (int i = 0; i < dim; ++i) {
    shape_functions<dim>(type, Vector<dim>(xi + h * Vector<dim>::Unit(i)), plus);
    shape_functions<dim>(type, Vector<dim>(xi - h * Vector<dim>::Unit(i)), minus);
    for (int a = 0; a < num_nodes(type); ++a) {
      EXPECT_NEAR(shape.dN[a][i], (plus.N[a] - minus.N[a]) / (2 * h), 1e-9) << name(type) << a;
    }
  }
}

TEST(QuadraticCells, shape_functions_are_one_at_their_node_and_add_up_to_one) {
  expect_nodal_shapes<1>(CellType::line3);
  expect_derivatives<1>(CellType::line3);
  for (const CellType type : plane_cells) {
    expect_nodal_shapes<2>(type);
    expect_derivatives<2>(type);
  }
  for (const CellType type : space_cells) {
    expect_nodal_shapes<3>(type);
    expect_derivatives<3>(type);
  }
}

/// Middle nodes as Gmsh 4.8 writes them, by their corners.
TEST(QuadraticCells, middle_nodes_stand_in_the_order_of_gmsh) {
  const auto tet10 = middle_nodes(CellType::tet10);
  EXPECT_EQ(std::vector<int>(tet10.begin(), tet10.end()),
            (std::vector<int>{0b0011, 0b0110, 0b0101, 0b1001, 0b1100, 0b1010}));
  EXPECT_TRUE(node_place<3>(CellType::hex20, 9).isApprox(Vector<3>(-1, 0, -1)));
  EXPECT_TRUE(node_place<3>(CellType::hex20, 15).isApprox(Vector<3>(-1, 1, 0)));
  EXPECT_TRUE(node_place<3>(CellType::hex27, 22).isApprox(Vector<3>(-1, 0, 0)));
  EXPECT_TRUE(node_place<3>(CellType::hex27, 24).isApprox(Vector<3>(0, 1, 0)));
  EXPECT_TRUE(node_place<3>(CellType::hex27, 26).isZero());
}

/// Area vectors of linear parts of the facets of a group.
template <int dim>
Vector<dim> area_of_parts(const Mesh<dim>& mesh, std::span<const std::int32_t> facets) {
  const CellType type = facet_type(mesh.cell_type);
  const auto parts = linear_parts(type);
  std::vector<std::int32_t> linear;
  for (std::size_t f = 0; f < facets.size(); f += num_nodes(type)) {
    for (const int place : parts) linear.push_back(facets[f + place]);
  }
  const CellType part = linear_part_nodes(type) == 2   ? CellType::line2
                        : linear_part_nodes(type) == 3 ? CellType::tri3
                                                       : CellType::quad4;
  Vector<dim> sum = Vector<dim>::Zero();
  for (const auto& area : facet_area_vectors<dim>(mesh.nodes, part, linear)) {
    EXPECT_GT(area.norm(), 0);
    sum += area;
  }
  return sum;
}

template <int dim>
void expect_sound_box(const Mesh<dim>& mesh, double volume, const Vector<dim>& right) {
  double sum = 0;
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) sum += cell_volume(mesh, c);
  EXPECT_NEAR(sum, volume, 1e-14);
  EXPECT_NEAR((area_of_parts<dim>(mesh, mesh.facets("right", "")) - right).norm(), 0, 1e-14);
  const std::vector<std::int32_t> around = boundary_facets(mesh);
  EXPECT_NEAR(area_of_parts<dim>(mesh, around).norm(), 0, 1e-14);
  for (const auto i : mesh.group_nodes("right", "")) EXPECT_EQ(mesh.nodes[i][0], 2);
  Mesh<dim> mirrored = mesh;
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
    const std::size_t n = mesh.nodes_per_cell();
    const auto nodes = std::span(mirrored.cells).subspan(c * n, n);
    mirror_cell(mesh.cell_type, nodes);
    EXPECT_NEAR(cell_volume(mirrored, c), -cell_volume(mesh, c), 1e-15);
    mirror_cell(mesh.cell_type, nodes);
  }
  EXPECT_EQ(mirrored.cells, mesh.cells);
}

TEST(QuadraticCells, boxes_have_outward_facets_that_split_into_linear_ones) {
  for (const CellType type : plane_cells) {
    SCOPED_TRACE(name(type));
    expect_sound_box<2>(box_mesh<2>({0, 0}, {2, 1}, {2, 2}, type), 2, {1, 0});
  }
  for (const CellType type : space_cells) {
    SCOPED_TRACE(name(type));
    expect_sound_box<3>(box_mesh<3>({0, 0, 0}, {2, 1, 1}, {2, 2, 2}, type), 2, {1, 0, 0});
  }
}

}  // namespace
}  // namespace gabion::test::test_quadratic_cells
