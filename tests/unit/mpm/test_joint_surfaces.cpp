// SPDX-License-Identifier: BSD-3-Clause
// Which surfaces are one for the search of contact by facets.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mpm_solver/contact/seams.hpp"

namespace gabion::test::test_joint_surfaces {
namespace {

constexpr double tolerance = 0.02;

using Line = std::vector<Vector<2>>;
using First = std::vector<std::int32_t>;

/// Soil is on the left of a line that goes to -x, above.
mpm::PlacedSurface<2> placed(const Line& line) {
  mpm::PlacedSurface<2> surface{.simplices = {}, .vertices = line};
  for (std::int32_t k = 0; k + 1 < std::ssize(line); ++k) surface.simplices.push_back({k, k + 1});
  return surface;
}

/// The line extruded along y, with vertices in rows from 0 to 1.
mpm::PlacedSurface<3> placed(const Line& line, const std::vector<double>& rows) {
  mpm::PlacedSurface<3> surface;
  const auto m = static_cast<std::int32_t>(rows.size());
  for (const Vector<2>& x : line) {
    for (const double y : rows) surface.vertices.emplace_back(x[0], y, x[1]);
  }
  for (std::int32_t i = 0; i + 1 < std::ssize(line); ++i) {
    for (std::int32_t j = 0; j + 1 < m; ++j) {
      const std::int32_t v = i * m + j;
      surface.simplices.push_back({v, v + 1, v + m + 1});
      surface.simplices.push_back({v, v + m + 1, v + m});
    }
  }
  return surface;
}

First joint(const std::vector<Line>& lines) {
  std::vector<mpm::PlacedSurface<2>> plane;
  std::vector<mpm::PlacedSurface<3>> space;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    plane.push_back(placed(lines[k]));
    const bool odd = k % 2 == 1;
    space.push_back(
        placed(lines[k], odd ? std::vector{0.0, 0.3, 1.0} : std::vector{0.0, 0.5, 1.0}));
  }
  const First first = mpm::joint_surfaces<2>(plane, tolerance);
  EXPECT_EQ(mpm::joint_surfaces<3>(space, tolerance), first);
  return first;
}

const First one = {0, 0}, two = {0, 1};

/// A line that rises to the left by an angle from a place.
Line rising(double degrees, Vector<2> from = {0, 0}) {
  const double angle = degrees * std::numbers::pi / 180;
  return {from, from + Vector<2>(-std::cos(angle), std::sin(angle))};
}

TEST(JointSurfaces, by_the_angle) {
  const Line floor = {{1, 0}, {0, 0}};
  for (const double degrees : {-150.0, -90.0, -45.0, -20.0, -1.0, 0.0, 1.0, 20.0, 45.0}) {
    EXPECT_EQ(joint({floor, rising(degrees)}), one) << degrees;
    EXPECT_EQ(joint({rising(degrees), floor}), one) << degrees;
  }
  for (const double degrees : {60.0, 80.0, 90.0, 100.0, 135.0}) {
    EXPECT_EQ(joint({floor, rising(degrees)}), two) << degrees;
    EXPECT_EQ(joint({rising(degrees), floor}), two) << degrees;
  }
}

TEST(JointSurfaces, with_gaps_overlaps_and_other_vertices) {
  const Line floor = {{1, 0}, {0.4, 0}, {0, 0}};
  EXPECT_EQ(joint({floor, {{-0.01, 0}, {-1, 0}}}), one);
  EXPECT_EQ(joint({floor, {{0.3, 0}, {0.2, 0}, {-1, 0}}}), one);
  EXPECT_EQ(joint({floor, {{0, 0.01}, {-1, 0.01}}}), one);
  EXPECT_EQ(joint({floor, {{-0.1, 0}, {-1, 0}}}), two);
  EXPECT_EQ(joint({floor, {{0, 0.1}, {-1, 0.1}}}), two);
  EXPECT_EQ(joint({floor, rising(20, {0.5, 0})}), one);     // a slope on the middle of a floor
  EXPECT_EQ(joint({floor, rising(90, {0.5, 0})}), two);     // a wall on it
  EXPECT_EQ(joint({floor, rising(90, {0.4, 0})}), two);     // at one of its vertices
  EXPECT_EQ(joint({floor, {{0.5, 1}, {0.5, 0}}}), two);     // its other side
  EXPECT_EQ(joint({floor, {{0.5, -0.3}, {0.5, 1}}}), two);  // through it
  EXPECT_EQ(joint({floor, {{0, -0.5}, {0, 0.5}}}), two);    // a floor that ends at a wall
  EXPECT_EQ(joint({floor, {{0, 0}, {0, -1}}}), one);        // a floor that ends at an edge
}

/// A sill stands on a floor in two pieces; its top is flush with a floor beyond it.
TEST(JointSurfaces, in_chains) {
  const Line right = {{2, 0}, {1.5, 0}}, left = {{1.5, 0}, {0.5, 0}};
  const Line sill = {{1, 0}, {1, 0.3}, {0.8, 0.3}}, upper = {{0.8, 0.3}, {0, 0.3}};
  EXPECT_EQ(joint({right, left, sill, upper}), (First{0, 0, 2, 2}));
  EXPECT_EQ(joint({upper, left, sill, right}), (First{0, 1, 0, 1}));
  EXPECT_EQ(joint({right}), First{0});
  EXPECT_EQ(joint({}), First{});
}

/// A box stands in a hole of its floor, or on the floor: at its corners floors meet faces that do
/// not look at them.
TEST(JointSurfaces, of_a_box_on_a_floor) {
  mpm::PlacedSurface<3> box{
      .simplices = {},
      .vertices = {
          {1, 1, 0}, {2, 1, 0}, {2, 2, 0}, {1, 2, 0}, {1, 1, 1}, {2, 1, 1}, {2, 2, 1}, {1, 2, 1}}};
  for (std::int32_t k = 0; k < 4; ++k) {
    const std::int32_t next = (k + 1) % 4;
    box.simplices.push_back({k, next, next + 4});
    box.simplices.push_back({k, next + 4, k + 4});
  }
  mpm::PlacedSurface<3> whole, hole;
  for (std::int32_t j = 0; j < 4; ++j) {
    for (std::int32_t i = 0; i < 4; ++i) {
      whole.vertices.emplace_back(i, j, 0);
      if (i == 3 || j == 3) continue;
      const std::int32_t v = 4 * j + i;
      for (auto* floor : {&whole, &hole}) {
        if (floor == &hole && i == 1 && j == 1) continue;
        floor->simplices.push_back({v, v + 1, v + 5});
        floor->simplices.push_back({v, v + 5, v + 4});
      }
    }
  }
  hole.vertices = whole.vertices;
  EXPECT_EQ(mpm::joint_surfaces<3>({box, whole}, tolerance), two);
  EXPECT_EQ(mpm::joint_surfaces<3>({box, hole}, tolerance), two);
  box.vertices = whole.vertices;  // a slab in the hole
  box.simplices = {{5, 6, 10}, {5, 10, 9}};
  EXPECT_EQ(mpm::joint_surfaces<3>({box, hole}, tolerance), one);
}

}  // namespace
}  // namespace gabion::test::test_joint_surfaces
