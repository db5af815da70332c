// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>

#include "common/mechanics/elements/cell_facets.hpp"
#include "common/mechanics/mesh/boundary.hpp"
#include "mpm_solver/grid/background_grid.hpp"
#include "mpm_solver/grid/sparse_list.hpp"
#include "tests/support/expect_error.hpp"

namespace gabion::mpm::test_box_grid {
namespace {

const Vector<2> low_2d(0.1, -3), high_2d(1.3, -1);
const Vector<3> low_3d(0.1, -3, 7), high_3d(1.3, -1, 7.7);

TEST(BoxGrid, is_told_from_the_mesh) {
  const auto plane = box_grid(box_mesh<2>(low_2d, high_2d, {6, 4}, CellType::quad4));
  ASSERT_TRUE(plane);
  EXPECT_EQ(plane->num_cells, (BoxGrid<2>::Index(6, 4)));
  EXPECT_LT((plane->spacing - Vector<2>(0.2, 0.5)).norm(), 1e-15);
  EXPECT_EQ(plane->low, low_2d);
  const auto space = box_grid(box_mesh<3>(low_3d, high_3d, {6, 4, 1}, CellType::hex8));
  ASSERT_TRUE(space);
  EXPECT_EQ(space->num_cells, (BoxGrid<3>::Index(6, 4, 1)));
  EXPECT_TRUE(box_grid(box_mesh<2>({4e5, 0}, {4e5 + 1, 1}, {300, 7}, CellType::quad4)));
}

TEST(BoxGrid, other_meshes_are_none) {
  EXPECT_FALSE(box_grid(box_mesh<2>(low_2d, high_2d, {6, 4}, CellType::tri3)));
  EXPECT_FALSE(box_grid(box_mesh<3>(low_3d, high_3d, {2, 2, 2}, CellType::tet4)));
  const auto mesh = box_mesh<2>(low_2d, high_2d, {6, 4}, CellType::quad4);
  auto moved = mesh;
  moved.nodes[9][1] += 1e-6;
  EXPECT_FALSE(box_grid(moved));
  auto swapped = mesh;
  std::swap(swapped.nodes[9], swapped.nodes[10]);
  for (auto& node : swapped.cells) node = node == 9 ? 10 : node == 10 ? 9 : node;
  EXPECT_FALSE(box_grid(swapped));
  auto reordered = mesh;
  std::swap_ranges(reordered.cells.begin(), reordered.cells.begin() + 4,
                   reordered.cells.begin() + 8);
  EXPECT_FALSE(box_grid(reordered));
  auto holed = mesh;
  holed.cells.resize(holed.cells.size() - 4);
  EXPECT_FALSE(box_grid(holed));
  auto mirrored = mesh;
  for (auto& x : mirrored.nodes) x[0] = -x[0];
  EXPECT_FALSE(box_grid(mirrored));
}

template <int dim>
void compare_with_locator(const Mesh<dim>& mesh) {
  const CellLocator<dim> locator(mesh);
  const auto grid = box_grid(mesh);
  ASSERT_TRUE(grid);
  const auto expect_same = [&](const Vector<dim>& x) {
    EXPECT_EQ(grid->locate(x), locator.locate(x, -1)) << x.transpose();
  };
  std::mt19937 engine(7);
  for (int k = 0; k < 500; ++k) {
    Vector<dim> x;
    for (int d = 0; d < dim; ++d) {
      const double share = -0.1 + 1.2 * static_cast<double>(engine()) / 4294967296.0;
      x[d] = mesh.nodes.front()[d] + share * (mesh.nodes.back() - mesh.nodes.front())[d];
    }
    expect_same(x);
    x[1] = mesh.nodes[engine() % mesh.nodes.size()][1];  // on a line of nodes
    expect_same(x);
  }
  for (const auto& node : mesh.nodes) {
    expect_same(node);
    for (const double step : {1e-14, -1e-14, 1e-7, -1e-7}) {
      expect_same(node + Vector<dim>::Constant(step));
    }
  }
  const double infinite = std::numeric_limits<double>::infinity();
  for (const double bad : {std::nan(""), infinite, -infinite, 1e300}) {
    Vector<dim> x = 0.5 * (mesh.nodes.front() + mesh.nodes.back());
    x[0] = bad;
    EXPECT_EQ(grid->locate(x), -1);
  }
}

TEST(BoxGrid, finds_the_cells_of_the_locator) {
  compare_with_locator(box_mesh<2>(low_2d, high_2d, {6, 4}, CellType::quad4));
  compare_with_locator(box_mesh<3>(low_3d, high_3d, {3, 4, 2}, CellType::hex8));
}

template <int dim>
void expect_same_cells(const BackgroundGrid<dim>& box, const Mesh<dim>& mesh) {
  const CellLocator<dim> locator(mesh);
  ASSERT_EQ(box.num_cells(), mesh.num_cells());
  const auto facets = boundary_facets(mesh);
  const std::set<std::int32_t> outer(facets.begin(), facets.end());
  const auto is_same = [](const CellList& a, std::span<const std::int32_t> b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end());
  };
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
    EXPECT_TRUE(is_same(box.cell(c), mesh.cell(c))) << c;
    EXPECT_TRUE(is_same(box.neighbours(c), locator.neighbours(c))) << c;
    for (int f = 0; f < num_facets(mesh.cell_type); ++f) {
      const auto nodes = cell_facet(mesh, c, f);
      const auto count = static_cast<std::size_t>(num_nodes(facet_type(mesh.cell_type)));
      EXPECT_TRUE(is_same(box.facet(c, f), std::span(nodes).first(count))) << c << " " << f;
    }
    EXPECT_NEAR(cell_volume(box, c), cell_volume(mesh, c), 1e-9 * cell_volume(mesh, c));
    double shortest = std::numeric_limits<double>::infinity();
    for (const auto a : mesh.cell(c)) {
      for (const auto b : mesh.cell(c)) {
        if (a < b) shortest = std::min(shortest, (mesh.nodes[a] - mesh.nodes[b]).norm());
      }
    }
    EXPECT_EQ(shortest_edge(box, c), shortest);
    const bool at_side = std::any_of(mesh.cell(c).begin(), mesh.cell(c).end(),
                                     [&](std::int32_t node) { return outer.contains(node); });
    EXPECT_EQ(box.box->at_side(c), at_side) << c;
  }
}

template <int dim>
void expect_same_places(const BackgroundGrid<dim>& box, const Mesh<dim>& mesh) {
  const CellLocator<dim> locator(mesh);
  ASSERT_EQ(box.num_nodes_total(), mesh.num_nodes_total());
  const double rounding = 2 * box.box->tolerance.maxCoeff();  // of xi, two for a cell
  for (std::int32_t n = 0; n < mesh.num_nodes_total(); ++n) {
    EXPECT_EQ(box.node(n), mesh.nodes[n]) << n;
    EXPECT_EQ(box.box->cells_around(n), locator.cells_at(mesh.nodes[n])) << n;
    EXPECT_EQ(box.box->num_cells_around(n), std::ssize(locator.cells_at(mesh.nodes[n]))) << n;
  }
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
    for (const auto a : mesh.cell(c)) {
      for (const auto b : mesh.cell(c)) {  // nodes, middles of edges, of facets and of the cell
        const Vector<dim> x = 0.5 * (mesh.nodes[a] + mesh.nodes[b]);
        EXPECT_EQ(box.cells_at(x), locator.cells_at(x)) << x.transpose();
        EXPECT_EQ(box.locate(x, -1), locator.locate(x, -1)) << x.transpose();
        const Vector<dim> xi = locator.local_coordinates(c, x);
        EXPECT_LT((box.local_coordinates(c, x) - xi).norm(), rounding) << x.transpose();
      }
    }
  }
  EXPECT_TRUE(box.cells_at(mesh.nodes.front() - Vector<dim>::Constant(1e-6)).empty());
}

/// A grid by numbers stores no mesh, and gives all answers of the same grid from a mesh.
template <int dim>
void compare_with_mesh(const Vector<dim>& low, const Vector<dim>& high,
                       const typename BoxGrid<dim>::Index& num_cells) {
  const auto mesh = box_mesh<dim>(low, high, num_cells, BoxGrid<dim>::cell_type);
  for (const auto& grid :
       {BackgroundGrid<dim>(BoxGrid<dim>(low, high, num_cells)), BackgroundGrid<dim>(mesh)}) {
    ASSERT_TRUE(grid.box);
    EXPECT_FALSE(grid.stored);
    EXPECT_EQ(grid.facet_groups, mesh.facet_groups);
    expect_same_cells(grid, mesh);
    expect_same_places(grid, mesh);
  }
}

TEST(BoxGrid, answers_as_the_mesh_would) {
  compare_with_mesh<2>(low_2d, high_2d, {6, 4});
  compare_with_mesh<2>({4e5, 0}, {4e5 + 1, 1}, {7, 1});
  compare_with_mesh<3>(low_3d, high_3d, {3, 4, 2});
  compare_with_mesh<3>(low_3d, high_3d, {1, 1, 3});
}

TEST(BoxGrid, refuses_what_has_no_cells) {
  const auto refuses = [](const Vector<2>& high, const BoxGrid<2>::Index& cells,
                          const std::string& reason) {
    test::expect_error<ConfigError>([&] { BoxGrid<2>(low_2d, high, cells); }, {reason});
  };
  refuses(low_2d, {2, 2}, "low < high");
  refuses(high_2d, {2, 0}, "found 0 cells");
  refuses(high_2d, {50000, 50000}, "32-bit");
  refuses({1, 1e200}, {4, 4}, "found coordinates up to 1e+200 beside cells of");
  refuses({1, 1e308}, {4, 1}, "the digits of the coordinates resolve");
  EXPECT_EQ(BoxGrid<2>(low_2d, high_2d, {40000, 50000}).num_cells_total(), 2000000000);
}

TEST(SparseList, keeps_what_was_set) {
  SparseList<int> list(1000000000, -1);
  EXPECT_LT(list.bytes(), 65e6);
  const std::vector<std::size_t> places = {999999999, 5, 64, 63, 0, 70000};
  for (const std::size_t i : places) list.at(i) = static_cast<int>(i / 5);
  std::vector<std::size_t> visited;
  list.for_each([&](std::size_t i, int& value) {
    EXPECT_EQ(value, static_cast<int>(i / 5));
    visited.push_back(i);
    value = 7;
  });
  EXPECT_EQ(visited, (std::vector<std::size_t>{0, 5, 63, 64, 70000, 999999999}));
  for (const std::size_t i : places) EXPECT_EQ(list[i], 7);
  for (const std::size_t i : {1, 62, 65, 69999, 999999998}) EXPECT_EQ(list[i], -1);
  list.assign(1000000000, 3);
  for (const std::size_t i : places) EXPECT_EQ(list[i], 3);
  list.for_each([](std::size_t, int) { FAIL(); });
}

}  // namespace
}  // namespace gabion::mpm::test_box_grid
