// SPDX-License-Identifier: BSD-3-Clause
// A plane is one plane, whatever its facets are.
#include <gtest/gtest.h>

#include "tests/unit/boulders/hard_scene.hpp"

namespace gabion::mpm::test_hard_contact_facets {
namespace {

template <int dim>
BodyState after(const BoulderShape<dim>& shape, int pieces, double half) {
  const HardBody body = hard_body(shape, {.friction = 0.6});
  Scene scene(dim, {body}, on_slope(dim, 0), {ground(dim, pieces, half)});
  BodyState& s = scene.now.states[0];
  s.x = {0.01371, 0, 0};
  s.x[dim - 1] = 0.72;
  s.v = {3, 0, 0};
  s.v[dim - 1] = -4;
  s.q = Eigen::AngleAxisd(0.5, dim == 2 ? Vector<3>::UnitZ() : Vector<3>::UnitX());
  scene.run(0.2);
  return scene.now.states[0];
}

template <int dim>
void expect_same(const BoulderShape<dim>& shape, std::initializer_list<int> pieces, double half) {
  const BodyState first = after(shape, 1, half);
  EXPECT_LT(first.v[0], 2.9);
  for (const int number : pieces) {
    const BodyState s = after(shape, number, half);
    EXPECT_LT((s.x - first.x).norm(), 1e-9) << number;
    EXPECT_LT((s.v - first.v).norm(), 1e-9 * first.v.norm()) << number;
    EXPECT_LT((s.W - first.W).norm(), 1e-9 * first.W.norm()) << number;
  }
}

TEST(HardContactFacets, a_disc_moves_the_same_on_fine_ground) {
  expect_same(sphere_shape<2>(0.5, 2650), {16, 80, 800}, 2);
}

TEST(HardContactFacets, a_sphere_moves_the_same_on_fine_ground) {
  expect_same(sphere_shape<3>(0.5, 2650), {8, 60}, 1.5);
}

TEST(HardContactFacets, a_polygon_moves_the_same_on_fine_ground) {
  expect_same(box_shape<2>({1, 0.8}, 2650), {16, 80, 800}, 2);
}

TEST(HardContactFacets, a_box_moves_the_same_on_fine_ground) {
  expect_same(box_shape<3>({1, 0.8, 0.7}, 2650), {8, 40}, 1.5);
}

// Ground that sticks out is felt between the vertices of a shape.
TEST(HardContactFacets, a_side_lies_on_a_ridge) {
  const HardBody block = hard_body(box_shape<2>({1, 0.8}, 2650), {});
  Obstacle ridge;
  ridge.start = {{0.9, -0.5, 0}, {0.02, 0, 0}, {-0.9, -0.5, 0}};
  ridge.end = ridge.start;
  ridge.facets = {{0, 1, -1}, {1, 2, -1}};
  Scene scene(2, {block}, on_slope(2, 0), {ridge});
  scene.now.states[0].x = {0, 0.4, 0};
  scene.run(0.1);
  EXPECT_GT(scene.now.states[0].x[1], 0.395);
}

}  // namespace
}  // namespace gabion::mpm::test_hard_contact_facets
