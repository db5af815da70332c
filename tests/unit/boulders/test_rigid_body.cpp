// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/boulders/rigid_body.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace gabion::mpm::test_rigid_body {
namespace {

BodyMass unequal_body() {
  BodyMass body;
  body.mass = 2;
  body.inertia = Vector<3>(1, 2, 3).asDiagonal();
  return body;
}

TEST(RigidBody, tumbling_keeps_energy_and_angular_momentum) {
  const BodyMass body = unequal_body();
  BodyState state;
  state.W = {0.6, 0.7, -0.4};
  const double dt = 0.1, energy = kinetic_energy(body, state);
  const Vector<3> momentum = angular_momentum(body, state);
  for (int k = 0; k < 20000; ++k) state = advance(body, state, {}, dt);
  EXPECT_NEAR(kinetic_energy(body, state) / energy, 1, 1e-13);
  EXPECT_LT((angular_momentum(body, state) - momentum).norm() / momentum.norm(), 1e-12);
  EXPECT_NEAR(state.q.norm(), 1, 1e-15);
}

TEST(RigidBody, energy_changes_by_the_work_of_an_eccentric_force) {
  const BodyMass body = unequal_body();
  BodyState state;
  state.W = {3, -2, 1};
  state.v = {1, 0, 2};
  const Vector<3> X(0.3, -0.8, 0.5), force(40, -30, 25);
  for (int k = 0; k < 50; ++k) {
    // The arm is known at the end: the fixed point is that of a contact.
    BodyState end = state;
    Vector<3> arm;
    for (int i = 0; i < 40; ++i) {
      arm = 0.5 * (state.q * X + end.q * X);
      end = advance(body, state, {force, arm.cross(force)}, 0.01);
    }
    arm = 0.5 * (state.q * X + end.q * X);
    const BodyMove move = move_of(state, end, 0.01);
    const Vector<3> path = move.shift + move.turn.cross(arm);
    EXPECT_LT((path - (end.at(X) - state.at(X))).norm(), 1e-13);
    EXPECT_NEAR(kinetic_energy(body, end) - kinetic_energy(body, state), force.dot(path), 1e-12);
    const Vector<3> gained = angular_momentum(body, end) - angular_momentum(body, state);
    EXPECT_LT((gained - 0.01 * arm.cross(force)).norm(), 1e-12);
    state = end;
  }
}

// Time from one flip of a spin about the middle axis to the next, by the sign of that spin.
double flip_period(double dt) {
  const BodyMass body = unequal_body();
  BodyState state;
  state.W = {0.01, 2, 0};
  double first = 0;
  for (double time = 0; time < 60; time += dt) {
    const BodyState end = advance(body, state, {}, dt);
    if (state.W[1] > 0 && end.W[1] <= 0) {
      const double crossing = time + dt * state.W[1] / (state.W[1] - end.W[1]);
      if (first > 0) return crossing - first;
      first = crossing;
    }
    state = end;
  }
  return 0;
}

TEST(RigidBody, period_of_flips_converges_with_the_square_of_the_step) {
  const double best = flip_period(0.0025);
  const double coarse = flip_period(0.02) - best, fine = flip_period(0.01) - best;
  EXPECT_GT(best, 1);
  EXPECT_NEAR(coarse / fine, 4.2, 0.5);
}

TEST(RigidBody, turns_in_the_plane_by_the_closed_form) {
  BodyMass disc;
  disc.mass = 3;
  disc.inertia = 1.5 * Matrix<3>::Identity();
  BodyState state;
  state.W = {0, 0, 2};
  const BodyState end = advance(disc, state, {.force = {3, 0, 0}, .moment = {0, 0, 6}}, 0.1);
  EXPECT_NEAR(end.W[2], 2.4, 1e-15);
  EXPECT_EQ(end.W[0], 0);
  EXPECT_NEAR(2 * std::atan2(end.q.z(), end.q.w()), 2 * std::atan(0.11), 1e-15);
  EXPECT_NEAR(end.v[0], 0.1, 1e-16);
}

}  // namespace
}  // namespace gabion::mpm::test_rigid_body
