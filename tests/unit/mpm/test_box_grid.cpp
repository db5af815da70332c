// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "mpm_solver/grid/box_grid.hpp"
#include "mpm_solver/grid/cell_locator.hpp"

namespace gabion::mpm {
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

TEST(BoxGrid, numbers_cells_and_nodes_as_the_mesh) {
  const auto mesh = box_mesh<3>(low_3d, high_3d, {3, 4, 2}, CellType::hex8);
  const auto grid = box_grid(mesh);
  ASSERT_TRUE(grid);
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
    const auto at = grid->cell_index(c);
    EXPECT_EQ(grid->node(at), mesh.cell(c)[0]);
    EXPECT_EQ(grid->node(at + BoxGrid<3>::Index::Ones()), mesh.cell(c)[6]);
  }
}

}  // namespace
}  // namespace gabion::mpm
