// SPDX-License-Identifier: BSD-3-Clause
// Distances of ellipsoids against their definitions.
#include "mpm_solver/boulders/ellipsoid.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "mpm_solver/boulders/ellipsoid_places.hpp"

namespace gabion::mpm::test_ellipsoid {
namespace {

struct Random {
  std::mt19937 generator{7};
  double in(double low, double high) { return low + (high - low) * generator() / 4294967296.; }
  Vector<3> vector(double size) { return {in(-size, size), in(-size, size), in(-size, size)}; }
  Eigen::Quaterniond turn() {
    return Eigen::Quaterniond(in(-1, 1), in(-1, 1), in(-1, 1), in(-1, 1)).normalized();
  }
  Ellipsoid ellipsoid(const Vector<3>& centre) {
    return {centre, turn(), {in(0.2, 1), in(0.2, 1), in(0.2, 1)}};
  }
};

/// x is on the surface where its normal is out, and y lies on that normal at the gap.
void expect_nearest(const Ellipsoid& e, const EllipsoidGap& gap, const Vector<3>& y) {
  EXPECT_NEAR(gap.out.norm(), 1, 1e-14);
  EXPECT_LT((e.support(gap.out) + gap.gap * gap.out - y).norm(), 1e-12);
}

TEST(Ellipsoid, a_point_lies_on_the_normal_of_its_nearest_place) {
  Random random;
  int inside = 0;
  for (int k = 0; k < 2000; ++k) {
    const Ellipsoid e = random.ellipsoid(random.vector(0.3));
    const Vector<3> y = random.vector(1.5);
    const EllipsoidGap gap = e.to_point(y);
    expect_nearest(e, gap, y);
    if (gap.gap < 0) ++inside;
    // No other direction is better outside.
    for (int i = 0; i < 20; ++i) {
      const Vector<3> n = random.vector(1).normalized();
      if (gap.gap > 0) {
        EXPECT_LE(n.dot(y - e.centre()) - e.extent(n), gap.gap + 1e-14);
      }
    }
  }
  EXPECT_GT(inside, 50);
}

// A sphere has all in closed form; on an axis two components of y are 0.
TEST(Ellipsoid, spheres_and_points_on_axes_have_closed_forms) {
  Random random;
  const Ellipsoid sphere({0.1, 0.2, 0.3}, random.turn(), {0.5, 0.5, 0.5});
  const Vector<3> y = {0.7, -0.4, 0.2};
  const Vector<3> d = y - sphere.centre();
  EXPECT_NEAR(sphere.to_point(y).gap, d.norm() - 0.5, 1e-15);
  EXPECT_LT((sphere.to_point(y).out - d.normalized()).norm(), 1e-15);
  const Ellipsoid e(Vector<3>::Zero(), Eigen::Quaterniond::Identity(), {3, 2, 1});
  EXPECT_NEAR(e.to_point({4, 0, 0}).gap, 1, 1e-15);
  EXPECT_NEAR(e.to_point({0, 0, 0.9}).gap, -0.1, 1e-15);
  EXPECT_NEAR(e.to_point({0, -2.5, 0}).gap, 0.5, 1e-15);
  EXPECT_NEAR(e.to_point(Vector<3>::Zero()).gap, -1, 1e-15);
  // Deeper than the radius of curvature 1/3: the two nearest places are beside the axis.
  const EllipsoidGap deep = e.to_point({2, 0, 0});
  expect_nearest(e, deep, {2, 0, 0});
  EXPECT_GT(deep.gap, -1);
}

TEST(Ellipsoid, in_the_plane_it_is_an_ellipse) {
  const Eigen::Quaterniond turned(Eigen::AngleAxisd(0.5, Vector<3>::UnitZ()));
  const Ellipsoid e({1, 2, 0}, turned, {0.3, 0.2, 0});
  for (const double angle : {0., 0.3, 2., 4., 5.5}) {
    const Vector<3> n(std::cos(angle), std::sin(angle), 0);
    const double c = std::cos(angle - 0.5), s = std::sin(angle - 0.5);
    EXPECT_NEAR(e.extent(n), std::hypot(0.3 * c, 0.2 * s), 1e-15);
    const EllipsoidGap gap = e.to_point(e.support(n) + 0.1 * n);
    EXPECT_NEAR(gap.gap, 0.1, 1e-14);
    EXPECT_EQ(gap.out[2], 0);
    const Ellipsoid other({1.5, 2.3, 0}, turned, {0.4, 0.1, 0});
    EXPECT_EQ(e.to(other).out[2], 0);
  }
}

TEST(Ellipsoid, a_line_lies_across_the_normal_of_its_nearest_place) {
  Random random;
  for (int k = 0; k < 500; ++k) {
    const Ellipsoid e = random.ellipsoid(random.vector(0.3));
    const Vector<3> x = random.vector(1.5), edge = random.vector(1).normalized();
    const EllipsoidGap gap = e.to_line(x, edge);
    EXPECT_NEAR(gap.out.dot(edge), 0, 1e-14);
    const Vector<3> y = e.support(gap.out) + gap.gap * gap.out;
    EXPECT_LT((y - x).cross(edge).norm(), 1e-12);
    const EllipsoidGap point = e.to_point(y);
    EXPECT_NEAR(gap.gap, point.gap, std::abs(gap.gap) < 0.02 || gap.gap > 0 ? 1e-12 : 1);
  }
}

// Two ellipsoids that are given by where they touch, and moved apart by a gap or into each other.
TEST(Ellipsoid, two_have_a_common_normal) {
  Random random;
  for (int k = 0; k < 2000; ++k) {
    const Ellipsoid first = random.ellipsoid(random.vector(1));
    const Vector<3> n = random.vector(1).normalized();
    const double given = random.in(-0.01, 0.3);
    const Eigen::Quaterniond turned = random.turn();
    const Vector<3> axes = {random.in(0.2, 1), random.in(0.2, 1), random.in(0.2, 1)};
    const Vector<3> arm = Ellipsoid(Vector<3>::Zero(), turned, axes).support(n);
    const Ellipsoid second(first.support(n) + given * n + arm, turned, axes);
    const EllipsoidGap gap = first.to(second);
    EXPECT_NEAR(gap.gap, given, 1e-13) << k;
    EXPECT_LT((gap.out - n).norm(), 1e-12) << k;
    EXPECT_NEAR(second.to(first).gap, given, 1e-13) << k;
  }
}

// The nearest place of a triangle against many places of it.
TEST(EllipsoidPlaces, no_place_of_a_triangle_is_nearer) {
  Random random;
  int faces = 0, edges = 0, corners = 0;
  for (int k = 0; k < 500; ++k) {
    const Ellipsoid e = random.ellipsoid(Vector<3>::Zero());
    HardCorners facet;
    for (Vector<3>& x : facet.x) x = random.vector(1.5) + Vector<3>(0, 0, -1.5);
    if (facet.normal()[2] < 0) std::swap(facet.x[0], facet.x[1]);
    EllipsoidPlace place;
    if (!place_on_facet({e, e, e}, {facet, facet, facet}, place)) continue;
    EXPECT_EQ(place.g0, place.g1);
    if (place.g0 < 0) continue;
    EXPECT_LT((place.x - place.g0 * place.direction - place_of(place.foot, facet)).norm(), 1e-12);
    constexpr int n = 12;
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; j <= n - i; ++j) {
        const Vector<3> y = (i * facet.x[0] + j * facet.x[1] + (n - i - j) * facet.x[2]) / n;
        EXPECT_GE(e.to_point(y).gap, place.g0 - 1e-13);
      }
    }
    ++(place.foot.is_face() ? faces : place.foot.support == 2 ? edges : corners);
  }
  EXPECT_GT(faces, 20);
  EXPECT_GT(edges, 20);
  EXPECT_GT(corners, 20);
}

}  // namespace
}  // namespace gabion::mpm::test_ellipsoid
