// SPDX-License-Identifier: BSD-3-Clause
// Impacts on what gives: Hunt and Crossley's force, whose damping follows from the restitution.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mpm_solver/boulders/boulder_law_config.hpp"
#include "mpm_solver/boulders/impact_damping.hpp"
#include "tests/unit/boulders/hard_scene.hpp"

namespace gabion::mpm::test_impact_damping {
namespace {

TEST(ImpactDamping, it_is_the_root_of_its_equation) {
  for (const double e : {0.1, 0.4, 0.7, 0.99}) {
    const double a = impact_damping(e);
    EXPECT_LT(e * a, 1);
    EXPECT_NEAR((std::log1p(a) - std::log1p(-e * a)) / (a * (1 + e)), 1, 1e-9);
  }
  EXPECT_NEAR(impact_damping(0.01), 100, 1e-6);  // e a is 1 to rounding
  EXPECT_EQ(impact_damping(1), 0);
  EXPECT_NEAR(impact_damping(1 - 1e-5) / 1.5e-5, 1, 1e-4);
  const double left = impact_damping(0.999 - 1e-9), right = impact_damping(0.999 + 1e-9);
  EXPECT_NEAR(left / right, 1, 1e-5);
  EXPECT_EQ(impact_damping(0), impact_damping(0.01));
}

TEST(ImpactDamping, the_key_says_where_it_ends) {
  const auto keys = boulder_law_keys();
  const auto found = std::ranges::find(keys, "restitution", &Key::name);
  ASSERT_NE(found, keys.end());
  EXPECT_NE(found->sentence.find("below 0.01 acts as 0.01"), std::string::npos);
}

/// A wall at 0 that gives, and may move.
Scene at_wall(const HardBody& body, double speed, double wall, double dt) {
  Scene scene(3, {body}, Vector<3>::Zero(), {ground(3)});
  scene.contact = HardContact(3, {body}, Vector<3>::Zero(), 1);
  scene.step.dt = dt;
  for (Vector<3>& x : scene.step.obstacles[0].end) x[2] += wall * dt;
  scene.now.states[0].x = {0.1, 0.2, body.radius + 1e-4};
  scene.now.states[0].v[2] = wall - speed;
  return scene;
}

void go_on(Scene& scene) {
  scene.advance();
  Obstacle& wall = scene.step.obstacles[0];
  const Vector<3> way = wall.end[0] - wall.start[0];
  for (auto* places : {&wall.start, &wall.end}) {
    for (Vector<3>& x : *places) x += way;
  }
}

// Drops with several speeds and masses, and a wall that moves; the time step does not matter, as
// substeps divide it.
TEST(ImpactDamping, a_drop_comes_back_with_its_restitution) {
  for (const double e : {0.0, 0.05, 0.2, 0.4, 0.7, 0.95, 1.0}) {
    for (const double speed : {0.3, 5.0, 30.0}) {
      const double density = speed == 5 ? 900 : 2650, wall = speed == 0.3 ? 1 : 0;
      const HardBody body =
          hard_body(sphere_shape<3>(0.2 + 0.01 * speed, density), {.restitution = e});
      Scene scene = at_wall(body, speed, wall, speed == 30 ? 1e-3 : 0.01);
      double energy = scene.energy();
      for (int k = 0; k < 60; ++k) {
        go_on(scene);
        const double before = energy;
        energy = scene.energy();
        if (wall == 0) {
          EXPECT_LE(energy, before * (1 + 1e-12)) << e << " " << speed;
        }
      }
      const double back = (scene.now.states[0].v[2] - wall) / speed;
      EXPECT_NEAR(back, std::max(e, 0.01), 2e-3) << e << " " << speed;
    }
  }
}

struct Course {
  double impulse = 0, change = 0;  // on the wall, and of the sphere's momentum [N s]
  double peak = 0, jump = 0;       // of the force, and its largest change in a step [N]
};
Course impact(double dt) {
  const HardBody body = hard_body(sphere_shape<3>(0.5, 2650), {.restitution = 0.4});
  Scene scene = at_wall(body, 5, 0, dt);
  Course course;
  double last = 0;
  for (int k = 0; k * dt < 0.01; ++k) {
    const auto end = scene.advance();
    double force = 0;
    for (const Vector<3>& f : end.nodal_forces[0]) force -= f[2];
    course.impulse += dt * force;
    course.peak = std::max(course.peak, force);
    course.jump = std::max(course.jump, std::abs(force - last));
    last = force;
  }
  course.change = body.mass.mass * (scene.now.states[0].v[2] + 5);
  return course;
}

/// The wall receives the momentum that the sphere loses; the force has no jump, also as it turns
/// back.
TEST(ImpactDamping, its_force_is_smooth_and_its_momentum_exact) {
  const Course coarse = impact(2e-5), fine = impact(5e-6);
  EXPECT_NEAR(coarse.impulse / coarse.change, 1, 1e-9);
  EXPECT_NEAR(fine.impulse / fine.change, 1, 1e-9);
  EXPECT_NEAR(coarse.peak / fine.peak, 1, 0.01);
  EXPECT_LT(fine.jump, 0.3 * coarse.jump);
}

}  // namespace
}  // namespace gabion::mpm::test_impact_damping
