// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "mpm_solver/contact/shortest_exit.hpp"
#include "tests/unit/mpm/soil_patch.hpp"

namespace gabion::test::test_shortest_exit {
namespace {

template <int dim>
Vector<dim> path(const mpm::ShortestExit<dim>& out, std::span<const Vector<dim>> normals) {
  Vector<dim> u = Vector<dim>::Zero();
  for (int k = 0; k < out.size; ++k) u += out.depths[k] * normals[out.planes[k]];
  return u;
}

TEST(ShortestExit, planes_at_right_angles_push_each_for_itself) {
  const std::vector<Vector<3>> normals = {{1, 0, 0}, {0, 0, 1}, {0, 1, 0}};
  const auto out = mpm::shortest_exit<3>(normals, std::vector<double>{0.1, 0.2, 0.3});
  ASSERT_EQ(out.size, 3);
  EXPECT_EQ(out.planes, (std::array<int, 3>{0, 1, 2}));
  EXPECT_NEAR(out.depths[0], 0.1, 1e-15);
  EXPECT_NEAR(out.depths[1], 0.2, 1e-15);
  EXPECT_NEAR(out.depths[2], 0.3, 1e-15);
}

TEST(ShortestExit, of_nearly_parallel_planes_the_deepest_pushes) {
  const std::vector<Vector<2>> normals = {{0, 1}, {1e-4, std::sqrt(1 - 1e-8)}};
  const auto out = mpm::shortest_exit<2>(normals, std::vector<double>{0.2, 0.1});
  ASSERT_EQ(out.size, 1);
  EXPECT_EQ(out.planes[0], 0);
  EXPECT_EQ(out.depths[0], 0.2);
}

/// u leads out of every plane, pushes only, and is perpendicular to what it leads out of for free:
/// the conditions of Karush, Kuhn and Tucker for the shortest one.
template <int dim>
void check_shortest() {
  Random random;
  for (int trial = 0; trial < 2000; ++trial) {
    std::vector<Vector<dim>> normals;
    std::vector<double> deltas;
    for (int k = 0; k < 2 + trial % 3; ++k) {
      const Vector<dim> n = random.template vector<dim>() + Vector<dim>::Unit(dim - 1);
      normals.push_back(n.normalized());
      deltas.push_back(0.1 + std::abs(random.template vector<dim>()[0]));
    }
    const auto out = mpm::shortest_exit<dim>(normals, deltas);
    const Vector<dim> u = path<dim>(out, normals);
    ASSERT_GT(out.size, 0);
    EXPECT_NEAR(out.length, u.norm(), 1e-14);
    for (std::size_t l = 0; l < normals.size(); ++l) {
      EXPECT_GT(normals[l].dot(u), deltas[l] * (1 - 1e-7)) << trial;
    }
    for (int k = 0; k < out.size; ++k) {
      EXPECT_GT(out.depths[k], 0);
      EXPECT_NEAR(normals[out.planes[k]].dot(u), deltas[out.planes[k]], 1e-9 * u.norm());
      if (k > 0) {
        EXPECT_LT(out.planes[k - 1], out.planes[k]);
      }
      double depth = 0;
      for (int l = 0; l < out.size; ++l) depth += out.inverse(k, l) * deltas[out.planes[l]];
      EXPECT_NEAR(depth, out.depths[k], 1e-9 * u.norm());
    }
  }
}

TEST(ShortestExit, is_the_shortest_way_out_of_all) {
  check_shortest<2>();
  check_shortest<3>();
}

}  // namespace
}  // namespace gabion::test::test_shortest_exit
