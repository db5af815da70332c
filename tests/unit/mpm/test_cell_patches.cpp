// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <set>

#include "mpm_solver/grid/patch_basis.hpp"
#include "tests/unit/mpm/soil_patch.hpp"

namespace gabion::test::test_cell_patches {
namespace {

/// Number of nodes of each patch. Checks that the patches are a partition, in the order they say.
template <int dim>
std::vector<std::size_t> patch_sizes(const Mesh<dim>& mesh, const mpm::CellPatches& patches) {
  std::vector<std::size_t> sizes;
  std::vector<int> count(mesh.num_cells(), 0);
  std::int32_t last_first = -1;
  for (std::int32_t k = 0; k < patches.size(); ++k) {
    std::set<std::int32_t> nodes;
    EXPECT_GT(patches.cells[patches.starts[k]], last_first);
    last_first = patches.cells[patches.starts[k]];
    for (std::int32_t i = patches.starts[k]; i < patches.starts[k + 1]; ++i) {
      const std::int32_t c = patches.cells[i];
      if (i > patches.starts[k]) {
        EXPECT_GT(c, patches.cells[i - 1]);
      }
      ++count[c];
      const auto cell = mesh.cell(c);
      nodes.insert(cell.begin(), cell.end());
    }
    sizes.push_back(nodes.size());
  }
  for (const int times : count) EXPECT_EQ(times, 1);
  return sizes;
}

template <int dim>
void check_box(CellType type, bool alternate, int cells_per_brick) {
  const Mesh<dim> mesh =
      box_mesh<dim>(Vector<dim>::Zero(), Vector<dim>::LinSpaced(1, 1.3),
                    Eigen::Matrix<int, dim, 1>::LinSpaced(3, 2 + dim), type, alternate);
  const mpm::CellLocator<dim> locator(mesh);
  const auto patches = mpm::join_cells(mesh, locator);
  for (const std::size_t nodes : patch_sizes(mesh, patches)) EXPECT_EQ(nodes, 1u << dim);
  ASSERT_EQ(patches.size() * cells_per_brick, mesh.num_cells()) << name(type);
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
    EXPECT_EQ(patches.cells[c], c) << name(type);  // the cells of a brick follow each other
  }
}

TEST(CellPatches, box_meshes_give_back_their_rectangles_and_bricks) {
  check_box<2>(CellType::tri3, false, 2);
  check_box<2>(CellType::tri3, true, 2);
  check_box<3>(CellType::tet4, false, 6);
  check_box<3>(CellType::tet4, true, 5);
}

/// A box mesh whose nodes were moved and whose cells were shuffled.
template <int dim>
Mesh<dim> disordered(CellType type, int cells) {
  Mesh<dim> mesh = unit_box<dim>(type, cells);
  Random random;
  for (auto& x : mesh.nodes) x += 0.1 / cells * random.template vector<dim>();
  const int n = mesh.nodes_per_cell();
  for (std::int32_t c = mesh.num_cells() - 1; c > 0; --c) {
    const auto other = static_cast<std::int32_t>(0.5 * (1 + random()) * (c + 1));
    std::swap_ranges(mesh.cells.begin() + c * n, mesh.cells.begin() + (c + 1) * n,
                     mesh.cells.begin() + other * n);
  }
  return mesh;
}

template <int dim>
void check_disordered(CellType type, double most_per_node) {
  const Mesh<dim> mesh = disordered<dim>(type, dim == 2 ? 12 : 5);
  const mpm::CellLocator<dim> locator(mesh);
  const auto patches = mpm::join_cells(mesh, locator);
  for (const std::size_t nodes : patch_sizes(mesh, patches)) {
    EXPECT_GE(nodes, 1u << dim) << name(type);
    EXPECT_LE(nodes, dim == 2 ? 6u : 16u) << name(type);
  }
  EXPECT_LT(patches.size(), most_per_node * mesh.num_nodes_total()) << name(type);
}

TEST(CellPatches, disordered_meshes_keep_their_degrees_of_freedom) {
  check_disordered<2>(CellType::tri3, 1);
  check_disordered<3>(CellType::tet4, 1);
}

/// The basis on patches is the basis of the cells in another order.
TEST(CellPatches, weights_are_those_of_the_cells) {
  const auto check = []<int dim>(CellType type) {
    SoilPatch<dim> by_cell(type), by_patch(type);
    by_cell.scatter(300);
    by_patch.scatter(300);
    by_patch.grid.patches = mpm::join_cells(by_patch.mesh, by_patch.grid.stored->locator);
    by_cell.to_grid();
    by_patch.to_grid();
    ASSERT_EQ(by_cell.nodes.grid_node, by_patch.nodes.grid_node);
    const double total = by_cell.nodes.m.front();
    for (std::size_t i = 0; i < by_cell.nodes.m.size(); ++i) {
      EXPECT_NEAR(by_patch.nodes.m[i], by_cell.nodes.m[i], 1e-12 * total);
      EXPECT_LT((by_patch.nodes.v[i] - by_cell.nodes.v[i]).norm(), 1e-12);
    }
    for (const auto& group : by_patch.weights.groups) {
      const auto nodes = by_patch.weights.nodes_of(group);
      EXPECT_EQ(std::set<std::int32_t>(nodes.begin(), nodes.end()).size(), nodes.size());
      for (std::int32_t e = group.first; e < group.last; ++e) {
        Vector<dim> x = Vector<dim>::Zero();
        Matrix<dim> unit = Matrix<dim>::Zero();
        for (int i = 0; i < by_patch.weights.num_nodes(e); ++i) {
          const auto& node = by_patch.mesh.nodes[nodes[by_patch.weights.local_of(e)[i]]];
          x += by_patch.weights.N_of(e)[i] * node;
          unit += node * by_patch.weights.grad_of(e)[i].transpose();
        }
        EXPECT_LT((x - by_patch.points.x[by_patch.weights.point[e]]).norm(), 1e-14);
        EXPECT_LT((unit - Matrix<dim>::Identity()).norm(), 1e-12);
      }
    }
  };
  check.template operator()<2>(CellType::tri3);
  check.template operator()<3>(CellType::tet4);
}

}  // namespace
}  // namespace gabion::test::test_cell_patches
