// SPDX-License-Identifier: BSD-3-Clause
// Where soil ends in air.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mpm_solver/contact/start_check.hpp"
#include "mpm_solver/step/free_surface.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test::test_free_surface {
namespace {

/// Regular points of the side `size` that fill a box, turned by an angle in the x-y plane.
template <int dim>
struct Block {
  mpm::BackgroundGrid<dim> grid;
  mpm::MaterialPoints<dim> points;
  std::vector<mpm::WallSettings> walls;
  double size;

  Block(const Vector<dim>& spacing, int cells, double size_)
      : grid(mpm::BoxGrid<dim>(Vector<dim>::Zero(), cells * spacing,
                               Eigen::Matrix<int, dim, 1>::Constant(cells)),
             mpm::Basis::gimp),
        size(size_) {
    points.body_starts = {0, 0};
  }
  /// @param stretch  of the distances along the axes by `size`
  void fill(const Vector<dim>& low, const Eigen::Matrix<int, dim, 1>& count,
            const Vector<dim>& stretch = Vector<dim>::Ones(), double angle = 0) {
    for (int k = 0; k < count.prod(); ++k) {
      Vector<dim> x;
      for (int d = 0, rest = k; d < dim; rest /= count[d], ++d) {
        x[d] = size * stretch[d] * (rest % count[d] + 0.5);
      }
      const Vector<dim> at = x;
      x[0] = std::cos(angle) * at[0] - std::sin(angle) * at[1];
      x[1] = std::sin(angle) * at[0] + std::cos(angle) * at[1];
      add_point<dim>({.id = points.size(),
                      .x = low + x,
                      .m = 1,
                      .V0 = std::pow(size, dim) * stretch.prod(),
                      .depth = 0.5 * size,
                      .half_length = Vector<dim>(0.5 * size * stretch)},
                     points);
    }
    points.body_starts.back() = points.size();
  }
  void close(const std::string& side) {
    mpm::WallSettings wall;
    wall.group = side;
    walls.push_back(wall);
  }
  std::vector<mpm::OuterPoint<dim>> surface(const mpm::FacetSights<dim>* sights = nullptr) {
    EXPECT_TRUE(find_cells(grid, points).empty());
    const std::vector<std::int32_t> bodies = {0};
    return mpm::find_free_surface<dim>(
        {.comm = MPI_COMM_NULL, .grid = grid, .points = points, .walls = walls, .surfaces = sights},
        bodies);
  }
};

template <int dim>
Vector<dim> sum_of_areas(const std::vector<mpm::OuterPoint<dim>>& surface) {
  Vector<dim> sum = Vector<dim>::Zero();
  for (const auto& each : surface) sum += each.area * each.n;
  return sum;
}
template <int dim>
double sum_of_sizes(const std::vector<mpm::OuterPoint<dim>>& surface) {
  double sum = 0;
  for (const auto& each : surface) sum += each.area;
  return sum;
}

/// The surface does not depend on how the lines of the grid cut the block.
TEST(FreeSurface, of_a_block_is_its_outermost_points) {
  for (const double offset : {0.0, 1.0 / 3, 0.5, 0.9}) {
    SCOPED_TRACE(offset);
    Block<2> plane({1, 1}, 8, 0.5);
    plane.fill({2 + offset, 2 + offset}, {8, 6});
    const auto around = plane.surface();
    EXPECT_EQ(around.size(), 24u);
    EXPECT_LT(sum_of_areas(around).norm(), 1e-12);
    Block<3> space({1, 1, 1}, 8, 0.5);
    space.fill({2 + offset, 2 + offset, 2 + offset}, {6, 6, 6});
    const auto all_around = space.surface();
    EXPECT_EQ(all_around.size(), 6u * 6 * 6 - 4 * 4 * 4);
    EXPECT_LT(sum_of_areas(all_around).norm(), 1e-12);
  }
}

/// Cells and points that are longer than wide have the surface of square ones.
TEST(FreeSurface, does_not_depend_on_the_shape_of_the_cells) {
  Block<2> block({4, 1}, 8, 0.5);
  block.fill({8.5, 2.25}, {6, 8}, {4, 1});
  const auto surface = block.surface();
  EXPECT_EQ(surface.size(), 24u);
  double upwards = 0;
  for (const auto& each : surface) upwards += std::max(0.0, each.area * each.n[1]);
  EXPECT_NEAR(upwards, 12, 0.1);
}

/// A block that was turned has its area within a third, and its normals within 20 degrees.
TEST(FreeSurface, of_a_turned_block) {
  for (const double angle : {0.1, 0.3, 0.5, 0.7, std::numbers::pi / 4}) {
    SCOPED_TRACE(angle);
    Block<2> block({1, 1}, 16, 0.5);
    block.fill({7.1, 2.3}, {12, 12}, {1, 1}, angle);
    const auto surface = block.surface();
    EXPECT_NEAR(sum_of_sizes(surface), 24, 8);
    for (const auto& each : surface) {
      const double turned = std::atan2(each.n[1], each.n[0]) - angle;
      const double nearest = std::numbers::pi / 2 * std::round(turned / (std::numbers::pi / 2));
      const Vector<2> local = block.points.x[each.point] - Vector<2>(7.1, 2.3);
      const double along = std::cos(angle) * local[0] + std::sin(angle) * local[1];
      const double across = -std::sin(angle) * local[0] + std::cos(angle) * local[1];
      EXPECT_LT(std::min({along, across, 6 - along, 6 - across}), 0.3) << local.transpose();
      if (std::min({along, 6 - along}) < 1 && std::min(across, 6 - across) < 1) continue;
      EXPECT_LT(std::abs(turned - nearest), 0.35) << local.transpose();
    }
  }
}

/// Layers that sheared, and soil that was strained by a third, have no surface inside.
TEST(FreeSurface, is_not_inside_of_strained_soil) {
  Block<2> block({1, 1}, 16, 0.5);
  block.fill({2.2, 2.4}, {12, 12}, {1.35, 0.74});
  for (auto& x : block.points.x) x[0] += 0.4 * x[1];
  for (const auto& each : block.surface()) {
    const Vector<2>& x = block.points.x[each.point];
    const double along = x[0] - 0.4 * x[1] - 2.2, across = x[1] - 2.4;
    EXPECT_LT(std::min({along / 1.35, across / 0.74, 6 - along / 1.35, 6 - across / 0.74}), 0.3)
        << x.transpose();
  }
}

/// A wall on a side of the grid closes it, another side does not.
TEST(FreeSurface, ends_at_walls_of_the_grid) {
  Block<2> block({1, 1}, 4, 0.5);
  block.fill({0, 0}, {8, 5});
  for (const char* side : {"left", "bottom"}) block.close(side);
  const auto surface = block.surface();
  EXPECT_EQ(surface.size(), 8u + 4);  // the top, and the side without a wall
  for (const auto& each : surface) {
    const Vector<2>& x = block.points.x[each.point];
    EXPECT_TRUE(x[1] > 2 || x[0] > 3.5) << x.transpose();
  }
  block.close("right");
  EXPECT_EQ(block.surface().size(), 8u);
}

/// Two bodies on each other have no surface between them.
TEST(FreeSurface, another_body_is_no_air) {
  Block<2> block({1, 1}, 8, 0.5);
  block.fill({2, 2}, {6, 6});
  block.points.body_starts = {0, block.points.size(), 0};
  block.fill({2, 5}, {6, 4});
  const auto surface = block.surface();
  EXPECT_EQ(surface.size(), 6u + 5 + 5);
  for (const auto& each : surface) EXPECT_LT(each.point, 36);
}

}  // namespace
}  // namespace gabion::test::test_free_surface
