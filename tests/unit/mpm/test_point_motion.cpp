// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step/surplus_motions.hpp"

#include <gtest/gtest.h>

#include "tests/unit/mpm/soil_patch.hpp"

namespace gabion::test::test_point_motion {
namespace {

constexpr double dt = 0.1;  // [s]

/// A filled box that goes along x with 1 m/s, but for a grain of 10 m/s in the last corner.
template <int dim>
SoilPatch<dim> with_fast_grain(CellType type) {
  SoilPatch<dim> soil(type, 4);
  soil.fill(1 << dim);
  const Vector<dim> along = Vector<dim>::Unit(0);
  for (std::size_t p = 0; p < soil.points.x.size(); ++p) soil.points.v[p] = along;
  soil.points.v.back() = 10 * along;
  soil.to_grid();
  return soil;
}

template <int dim>
void check_speeds(CellType type) {
  const SoilPatch<dim> soil = with_fast_grain<dim>(type);
  const std::int32_t grain = soil.points.cell[soil.points.size() - 1];
  for (const mpm::CellGroup& group : soil.weights.groups) {
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const std::int32_t p = soil.weights.point[e];
      const double speed = mpm::fastest_about(soil.points, soil.weights, soil.nodes, group, e);
      if (p == soil.points.size() - 1) {
        EXPECT_DOUBLE_EQ(speed, 10);
      }
      if (soil.points.cell[p] == grain) {
        EXPECT_GT(speed, 1.1) << p;
      }
      if (soil.points.x[p][0] < 0.5) {
        EXPECT_NEAR(speed, 1, 1e-12) << p;
      }
    }
  }
}

TEST(FastestAbout, is_that_of_a_point_and_its_nodes) {
  check_speeds<2>(CellType::quad4);
  check_speeds<3>(CellType::hex8);
}

/// The grain lets itself and its neighbours move farther, not all points.
TEST(SurplusMotion, is_beyond_what_each_point_could_expect) {
  const SoilPatch<2> soil = with_fast_grain<2>(CellType::quad4);
  const auto largest = [&](double path) {
    std::vector<double> du(soil.nodes.m.size() * 2, 0.0);
    for (std::size_t k = 0; k < du.size(); k += 2) du[k] = path;
    return mpm::SurplusMotions<2>().largest({soil.points, soil.weights, soil.nodes, du, dt});
  };
  EXPECT_NEAR(largest(2 * dt), 0, 1e-12);
  EXPECT_NEAR(largest(2 * dt + 0.3), 0.3, 1e-12);
  EXPECT_NEAR(largest(0), -2 * dt, 1e-12);
}

/// Whichever nodes move otherwise than in the solution before.
TEST(SurplusMotion, follows_the_nodes_that_move_otherwise) {
  const SoilPatch<2> soil = with_fast_grain<2>(CellType::quad4);
  std::vector<double> du(soil.nodes.m.size() * 2, 0.1 * dt);
  mpm::SurplusMotions<2> paths;
  for (std::size_t k = 0; k <= du.size(); ++k) {
    const double fresh =
        mpm::SurplusMotions<2>().largest({soil.points, soil.weights, soil.nodes, du, dt});
    EXPECT_EQ(paths.largest({soil.points, soil.weights, soil.nodes, du, dt}), fresh) << k;
    if (k < du.size()) du[k] = (k % 3 == 0 ? 9 : -1) * dt;
  }
}

}  // namespace
}  // namespace gabion::test::test_point_motion
