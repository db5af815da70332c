// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "common/mechanics/elements/quadratic_cells.hpp"
#include "common/mechanics/mesh/gmsh_file.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/support/gmsh_text.hpp"

namespace gabion::test::test_quadratic_meshes {
namespace {

/// Numbers of Gmsh's element types.
int gmsh_type(CellType type) {
  for (int number = 1; number < 20; ++number) {
    if (cell_type_of_gmsh(number) == type) return number;
  }
  return 0;
}

/// A box of the cells as a file, with the facets of its right side; nodes count from 1.
template <int dim>
GmshText file_of(const Mesh<dim>& mesh) {
  GmshText file{.groups = {{dim - 1, 1, "right"}, {dim, 2, "body"}},
                .entities = {{dim - 1, 1, {1}}, {dim, 1, {2}}},
                .nodes = {},
                .blocks = {}};
  for (const auto& X : mesh.nodes) file.nodes.push_back({X[0], X[1], dim == 3 ? X[dim - 1] : 0.0});
  const auto rows = [](std::span<const std::int32_t> nodes, std::size_t n) {
    std::vector<std::vector<int>> elements;
    for (std::size_t first = 0; first < nodes.size(); first += n) {
      auto& element = elements.emplace_back();
      for (const auto i : nodes.subspan(first, n)) element.push_back(i + 1);
    }
    return elements;
  };
  const CellType facet = facet_type(mesh.cell_type);
  file.blocks.push_back(
      {dim - 1, 1, gmsh_type(facet), rows(mesh.facets("right", ""), num_nodes(facet))});
  file.blocks.push_back(
      {dim, 1, gmsh_type(mesh.cell_type), rows(mesh.cells, mesh.nodes_per_cell())});
  return file;
}

template <int dim>
Mesh<dim> read(const GmshText& file) {
  const TemporaryMesh mesh(file);
  return read_gmsh<dim>(mesh.path(), std::nullopt, CellOrders::any);
}

/// Cells whose file runs around the other way are turned, with their middle nodes.
template <int dim>
void expect_read_back(const Mesh<dim>& mesh) {
  SCOPED_TRACE(name(mesh.cell_type));
  Mesh<dim> turned = mesh;
  const std::size_t n = mesh.nodes_per_cell();
  mirror_cell(mesh.cell_type, std::span(turned.cells).first(n));
  for (const Mesh<dim>& given : {mesh, turned}) {
    const Mesh<dim> found = read<dim>(file_of(given));
    EXPECT_EQ(found.cell_type, mesh.cell_type);
    EXPECT_EQ(found.cells, mesh.cells);
    EXPECT_EQ(found.facets("right", ""), mesh.facets("right", ""));
    EXPECT_EQ(found.cell_groups.at("body").size(), static_cast<std::size_t>(mesh.num_cells()));
  }
}

TEST(QuadraticMeshes, are_read_as_written_and_turned_where_their_volume_is_negative) {
  for (const CellType type : {CellType::tri6, CellType::quad8, CellType::quad9}) {
    expect_read_back(box_mesh<2>({0, 0}, {2, 1}, {2, 1}, type));
  }
  for (const CellType type : {CellType::tet10, CellType::hex20, CellType::hex27}) {
    expect_read_back(box_mesh<3>({0, 0, 0}, {2, 1, 1}, {2, 1, 1}, type));
  }
}

/// The middle node of an edge behind the quarter of its length folds the cell at the corner.
TEST(QuadraticMeshes, folded_cells_are_refused_with_cell_and_place) {
  for (const CellType type : {CellType::quad8, CellType::quad9, CellType::tri6}) {
    auto mesh = box_mesh<2>({0, 0}, {2, 1}, {2, 1}, type);
    std::size_t middle = 0;
    for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
      if (mesh.nodes[i] == Vector<2>(0.5, 0)) middle = i;
    }
    mesh.nodes[middle][0] = 0.26;
    EXPECT_EQ(read<2>(file_of(mesh)).num_cells(), mesh.num_cells());
    mesh.nodes[middle][0] = 0.2;
    const auto bad = [&] { read<2>(file_of(mesh)); };
    expect_error<ConfigError>(bad, {"found a degenerate, folded or non-convex " + name(type) +
                                    " near (0, 0), element 2, allowed: cells of positive"});
  }
}

TEST(QuadraticMeshes, are_refused_where_linear_cells_are_wanted) {
  const TemporaryMesh mesh(file_of(box_mesh<3>({0, 0, 0}, {1, 1, 1}, {1, 1, 1}, CellType::tet10)));
  expect_error<ConfigError>([&] { read_gmsh<3>(mesh.path()); },
                            {"found cells of type tet10, which are of order 2, allowed: tet4"});
}

TEST(QuadraticMeshes, facets_of_another_order_belong_to_no_cell) {
  auto file = file_of(box_mesh<2>({0, 0}, {2, 1}, {2, 1}, CellType::quad8));
  file.blocks[0].type = 1;
  file.blocks[0].elements[0].pop_back();
  expect_error<ConfigError>([&] { read<2>(file); },
                            {"found a facet of group \"right\"", "that belongs to no cell"});
}

}  // namespace
}  // namespace gabion::test::test_quadratic_meshes
