// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "tests/unit/boulders/hard_scene.hpp"

namespace gabion::mpm::test_hard_contact {
namespace {

// Depth at which the ground carries the weight.
double rest_depth(const HardBody& body, double weight) {
  return std::sqrt(body.mass.mass * weight / body.law.stiffness);
}

template <int dim>
double speed_down(double friction, double* spin = nullptr) {
  const HardBody body = hard_body(sphere_shape<dim>(0.5, 2650), {.friction = friction});
  Scene scene(dim, {body}, on_slope(dim, 30), {ground(dim)});
  scene.now.states[0].x[0] = -5;
  scene.now.states[0].x[dim - 1] = 0.5 - rest_depth(body, g * std::cos(std::numbers::pi / 6));
  scene.run(1);
  if (spin != nullptr) *spin = 0.5 * scene.now.states[0].spin().norm();
  return scene.now.states[0].v[0];
}

TEST(HardContact, balls_roll_down_a_slope_by_their_inertia) {
  EXPECT_NEAR(speed_down<2>(0.5), 2. / 3 * g * 0.5, 0.003);
  EXPECT_NEAR(speed_down<3>(0.5), 5. / 7 * g * 0.5, 0.003);
}

TEST(HardContact, a_disc_slides_with_too_little_friction) {
  double spin = 0;
  EXPECT_NEAR(speed_down<2>(0.1, &spin), 4.055429, 0.002);
  EXPECT_NEAR(spin, 1.699142, 0.002);
}

TEST(HardContact, a_sliding_ball_rolls_at_its_known_speed) {
  const HardBody disc = hard_body(sphere_shape<2>(0.5, 2650), {.friction = 0.4});
  Scene flat(2, {disc}, on_slope(2, 0), {ground(2)});
  flat.now.states[0].x = {-5, 0.5 - rest_depth(disc, g), 0};
  flat.now.states[0].v[0] = 3;
  flat.run(1);
  EXPECT_NEAR(flat.now.states[0].v[0], 2, 2e-3);
  const HardBody sphere = hard_body(sphere_shape<3>(0.5, 2650), {.friction = 0.4});
  Scene space(3, {sphere}, on_slope(3, 0), {ground(3)});
  space.now.states[0].x = {-5, 0.3, 0.5 - rest_depth(sphere, g)};
  space.now.states[0].v[0] = 3;
  space.run(1);
  EXPECT_NEAR(space.now.states[0].v[0], 15. / 7, 2e-3);
}

TEST(HardContact, a_drop_comes_back_with_its_restitution) {
  for (const double e : {0.2, 0.5, 1.0}) {
    const HardBody body = hard_body(sphere_shape<3>(0.5, 2650), {.restitution = e});
    Scene scene(3, {body}, Vector<3>::Zero(), {ground(3)});
    scene.now.states[0].x = {0.1, 0.2, 0.52};
    scene.now.states[0].v[2] = -5;
    scene.run(0.05);
    EXPECT_NEAR(scene.now.states[0].v[2], 5 * e, e == 1 ? 1e-10 : 0.04);
  }
}

TEST(HardContact, a_pair_of_balls_keeps_momentum_and_its_energy_if_elastic) {
  std::vector<HardBody> bodies = {
      hard_body(sphere_shape<3>(0.5, 2650), {.friction = 0, .restitution = 1}),
      hard_body(sphere_shape<3>(0.3, 2000), {.friction = 0, .restitution = 1})};
  Scene scene(3, bodies, Vector<3>::Zero(), {});
  scene.now.states[1].x = {0.9, 0.3, 0.1};
  scene.now.states[1].v = {-6, 0, 0};
  const double energy = scene.energy();
  const Vector<3> before = bodies[1].mass.mass * scene.now.states[1].v;
  scene.run(0.2);
  Vector<3> after = Vector<3>::Zero();
  for (int c = 0; c < 2; ++c) after += bodies[c].mass.mass * scene.now.states[c].v;
  EXPECT_LT((after - before).norm(), 1e-12 * before.norm());
  EXPECT_NEAR(scene.energy() / energy, 1, 1e-11);
  EXPECT_GT(scene.now.states[0].v.norm(), 0.5);
}

// The ground receives the momentum that the body loses; friction and impacts only take energy.
TEST(HardContact, a_tumbling_block_never_gains) {
  const HardBody block = hard_body(box_shape<2>({1, 0.5}, 2000), {.friction = 0.4});
  Scene scene(2, {block}, on_slope(2, 0), {ground(2)});
  scene.now.states[0].x = {0, 1.2, 0};
  scene.now.states[0].q = Eigen::AngleAxisd(0.5, Vector<3>::UnitZ());
  scene.now.states[0].v[0] = 1;
  double energy = scene.energy();
  for (int k = 0; k < 600; ++k) {
    const Vector<3> v = scene.now.states[0].v;
    const auto end = scene.advance();
    Vector<3> ground_force = Vector<3>::Zero();
    for (const Vector<3>& f : end.nodal_forces[0]) ground_force += f;
    const Vector<3> gained = block.mass.mass * (scene.now.states[0].v - v) / scene.step.dt;
    EXPECT_LT((gained - block.mass.mass * scene.down + ground_force).norm(),
              1e-6 * block.mass.mass * g);
    const double before = energy;
    energy = scene.energy();
    EXPECT_LT(energy, before * (1 + 1e-12));
  }
  EXPECT_LT(scene.now.states[0].v.norm(), 1e-4);
  EXPECT_NEAR(std::abs(scene.now.states[0].x[1]), 0.25, 0.005);
}

TEST(HardContact, a_frictionless_elastic_block_keeps_its_energy) {
  const HardBody block = hard_body(box_shape<2>({1, 0.5}, 2000), {.friction = 0, .restitution = 1});
  Scene scene(2, {block}, on_slope(2, 0), {ground(2)});
  scene.now.states[0].x = {0.3, 1.2, 0};
  scene.now.states[0].q = Eigen::AngleAxisd(0.5, Vector<3>::UnitZ());
  const double first = scene.energy();
  scene.run(2);
  EXPECT_NEAR(scene.energy() / first, 1, 1e-9);
}

TEST(HardContact, a_pyramid_stands_by_friction_alone) {
  EXPECT_LT(pyramid_speed(1.05 * std::tan(std::numbers::pi / 12)), 1e-6);
  EXPECT_GT(pyramid_speed(0.95 * std::tan(std::numbers::pi / 12)), 1e-3);
}

TEST(HardContact, rolling_resistance_holds_a_ball_on_a_slope) {
  HardBody body = hard_body(sphere_shape<2>(0.5, 2650), {.friction = 0.8, .rolling = 0.2});
  const auto speed_at = [&](double degrees) {
    Scene scene(2, {body}, on_slope(2, degrees), {ground(2)});
    scene.now.states[0].x = {-5, 0.5, 0};
    scene.run(3);
    return scene.now.states[0].v[0];
  };
  EXPECT_LT(std::abs(speed_at(10)), 1e-5);  // tan 10 deg = 0.176
  EXPECT_NEAR(speed_at(20), 3 * 2. / 3 * g * (std::sin(0.349066) - 0.2 * std::cos(0.349066)), 0.02);
}

// A vertex of fine ground just inside a corner of a shape is deep behind the side next to it.
TEST(HardContact, a_polygon_on_fine_ground_does_not_gain) {
  for (const int pieces : {40, 200, 400, 1600}) {
    const HardBody block = hard_body(box_shape<2>({1, 0.8}, 2650), {.friction = 0.6});
    Scene scene(2, {block}, on_slope(2, 0), {ground(2, pieces)});
    scene.now.states[0].x = {0.013, 0.7, 0};
    scene.now.states[0].q = Eigen::AngleAxisd(0.5, Vector<3>::UnitZ());
    scene.now.states[0].v = {3, -2, 0};
    double energy = scene.energy();
    for (int k = 0; k < 200; ++k) {
      scene.advance();
      EXPECT_LT(scene.energy(), energy * (1 + 1e-9)) << pieces << " " << k;
      energy = scene.energy();
    }
  }
}

TEST(HardContact, a_held_body_does_not_drive_others_by_its_spin) {
  std::vector<HardBody> discs(2, hard_body(sphere_shape<2>(0.5, 2650), {.friction = 0.5}));
  Scene scene(2, discs, on_slope(2, 0), {});
  scene.step.held = {1, 0};
  scene.now.states[0].W[2] = 20;
  scene.now.states[1].x = {0, 1, 0};
  double work = 0;
  for (int k = 0; k < 40; ++k) work += std::abs(scene.advance().works[0]);
  EXPECT_EQ(scene.now.states[1].v[0], 0);
  EXPECT_EQ(scene.now.states[1].W[2], 0);
  EXPECT_EQ(work, 0);
  EXPECT_EQ(scene.now.states[0].x, Vector<3>::Zero());
}

// A gap of rounding size is no reason for short substeps where nothing moves freely.
TEST(HardContact, a_held_body_just_over_the_ground_needs_no_substeps) {
  std::vector<HardBody> discs(2, hard_body(sphere_shape<2>(0.5, 2650), {}));
  Scene scene(2, discs, on_slope(2, 0), {ground(2)});
  scene.step.held = {1, 0};
  scene.now.states[0].x = {-3, 0.5 + 1e-12, 0};
  scene.now.states[1].x = {3, 5, 0};
  scene.now.states[1].v = {2, 0, 0};
  EXPECT_LE(scene.advance().substeps, 2);
}

TEST(HardContact, motion_far_from_the_origin_is_the_same) {
  const HardBody block = hard_body(box_shape<2>({1, 0.5}, 2000), {.friction = 0.4});
  std::array<Vector<3>, 2> at;
  for (const int far : {0, 1}) {
    const Vector<3> origin = far * Vector<3>(4e6, 5e6, 0);
    Obstacle plane = ground(2);
    for (auto* places : {&plane.start, &plane.end}) {
      for (Vector<3>& x : *places) x += origin;
    }
    Scene scene(2, {block}, on_slope(2, 0), {plane});
    scene.now.states[0].x = origin + Vector<3>(0, 0.75, 0);
    scene.now.states[0].q = Eigen::AngleAxisd(0.5, Vector<3>::UnitZ());
    scene.now.states[0].v[0] = 1;
    scene.run(0.4);
    at[far] = scene.now.states[0].x - origin;
  }
  EXPECT_LT((at[1] - at[0]).norm(), 2e-7);  // places have a rounding of 5e-10 m in each step
}

TEST(HardContact, the_deepest_overlap_is_named) {
  std::vector<HardBody> bodies(2, hard_body(sphere_shape<2>(0.5, 2650), {}));
  const HardContact contact(2, bodies, Vector<3>::Zero());
  std::vector<BodyState> states(2);
  states[0].x = {0, 0.51, 0};
  states[1].x = {0.95, 0.51, 0};
  const auto two = contact.deepest_overlap(states, {ground(2)});
  EXPECT_NEAR(two.depth, 0.05, 1e-12);
  EXPECT_EQ(two.other, 1);
  states[1].x = {3, 0.4, 0};
  const auto wall = contact.deepest_overlap(states, {ground(2)});
  EXPECT_NEAR(wall.depth, 0.1, 1e-12);
  EXPECT_EQ(wall.body, 1);
  EXPECT_EQ(wall.other, 2);
}

}  // namespace
}  // namespace gabion::mpm::test_hard_contact
