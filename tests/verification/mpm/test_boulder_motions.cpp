// SPDX-License-Identifier: BSD-3-Clause
// Rigid bodies that roll, tumble and rock, against closed forms of rigid bodies.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/support/verification_row.hpp"
#include "tests/unit/boulders/hard_scene.hpp"

namespace gabion::mpm {
namespace {

using test::Measure;
using test::verify;

void row(const std::string& id, const std::string& what, double exact, double computed,
         double bound, const std::string& unit) {
  verify(
      {.id = id, .what = what, .exact = exact, .computed = computed, .bound = bound, .unit = unit});
}

/// A ring that rolls has half the acceleration of a body that slides without friction.
TEST(VB4_Rolling, ring_on_a_slope) {
  HardBody ring = hard_body(sphere_shape<2>(0.5, 2650), {.friction = 0.5});
  ring.mass.inertia = ring.mass.mass * 0.25 * Matrix<3>::Identity();
  Scene scene(2, {ring}, on_slope(2, 30), {ground(2)});
  const double weight = ring.mass.mass * g * std::sqrt(0.75);
  scene.now.states[0].x = {-5, 0.5 - std::sqrt(weight / ring.law.stiffness), 0};
  scene.run(1);
  row("VB4", "ring on 30 deg, rolls: speed after 1 s", g / 4, scene.now.states[0].v[0], 1e-4,
      "m/s");
}

constexpr double middle_spin = 2, small_spin = 0.2;

/// Time in which a body with the moments 1, 2, 3 that spins about its middle axis turns over twice.
double time_of_two_flips(double dt) {
  BodyMass body;
  body.mass = 1;
  body.inertia = Vector<3>(1, 2, 3).asDiagonal();
  BodyState state;
  state.W = {small_spin, middle_spin, 0};
  std::vector<double> zeros;  // of the spin about the middle axis
  for (int k = 0; zeros.size() < 3; ++k) {
    const double before = state.W[1];
    state = advance(body, state, {}, dt);
    if (before * state.W[1] <= 0) zeros.push_back(dt * (k + before / (before - state.W[1])));
  }
  return zeros[2] - zeros[0];
}

/// A free body that spins about its middle axis turns over again and again: Euler's equations have
/// the period 4 K(k) sqrt(J1 J2 J3 / ((J2 - J1) (2 E J3 - L^2))) with k^2 = (J3 - J2) (L^2 - 2 E
/// J1) / ((J2 - J1) (2 E J3 - L^2)), where L^2 < 2 E J2 (Landau and Lifshitz 1976, § 37).
TEST(VB7_Tumbling, period_of_the_flips) {
  const double E2 = std::pow(small_spin, 2) + 2 * std::pow(middle_spin, 2);
  const double L2 = std::pow(small_spin, 2) + 4 * std::pow(middle_spin, 2);
  ASSERT_LT(L2, 2 * E2);
  const double k = std::sqrt((L2 - E2) / (3 * E2 - L2));
  const double exact = 4 * std::comp_ellint_1(k) * std::sqrt(6 / (3 * E2 - L2));
  const double coarse = std::abs(time_of_two_flips(0.04) - exact),
               fine = std::abs(time_of_two_flips(0.01) - exact);
  row("VB7", "free body about its middle axis: period of its flips, 0.01 s", exact,
      time_of_two_flips(0.01), 1e-3, "s");
  verify({.id = "VB7",
          .what = "free body about its middle axis: order of the period, 0.04 to 0.01 s",
          .exact = 2,
          .computed = std::log(coarse / fine) / std::log(4),
          .measure = Measure::order,
          .bound = 1.9});
}

/// Angle of a body in the plane.
double angle_of(const BodyState& state) {
  return 2 * std::atan2(state.q.z(), state.q.w());
}

constexpr double alpha = 0.25;  // slenderness of a block with the half diagonal 1 m

/// The block stands on one edge, off its rest by alpha / 2, and rocks without sliding.
/// @param on_feet  the base is hollow, so that it touches the ground at its two edges alone
Scene rocking_block(bool on_feet) {
  const double b = std::sin(alpha), h = std::cos(alpha), hollow = 0.02;
  HardBody block = hard_body(box_shape<2>({2 * b, 2 * h}, 2000), {.friction = 5, .restitution = 0});
  block.law.stiffness *= 100;
  for (Vector<3>& X : block.vertices) {
    if (on_feet && X[1] < -h + 1e-9 && std::abs(X[0]) < b - 1e-9) X[1] += hollow;
  }
  Scene scene(2, {block}, on_slope(2, 0), {ground(2)});
  scene.step.dt = 1e-3;
  BodyState& state = scene.now.states[0];
  state.q = Eigen::AngleAxisd(-0.5 * alpha, Vector<3>::UnitZ());
  state.x = state.q * Vector<3>(-b, h, 0) + Vector<3>(0, 1e-9, 0);
  return scene;
}

/// The first quarter of a period lasts acosh(2) / p with p^2 = 3 g / 4, for small angles (Housner
/// 1963).
TEST(VB7_RockingBlock, time_to_the_first_impact) {
  Scene scene = rocking_block(false);
  double quarter = 0;
  for (int n = 0; n < 1000 && quarter == 0; ++n) {
    const double before = angle_of(scene.now.states[0]);
    scene.advance();
    const double now = angle_of(scene.now.states[0]);
    if (now >= 0) quarter = scene.step.dt * (n - before / (now - before));
  }
  row("VB7", "block that rocks from half its slenderness: four times the time to the first impact",
      1.942078, 4 * quarter, 0.005, "s");
}

/// Angular speed after over before the first impact, from the largest angles before and after.
double speed_ratio(Scene scene) {
  double largest = 0;
  const auto energy = [](double tilt) { return std::cos(alpha - tilt) - std::cos(alpha); };
  for (int n = 0; n < 2000; ++n) {
    scene.advance();
    const double now = angle_of(scene.now.states[0]);
    if (largest > 0.02 && now < largest) break;
    largest = std::max(largest, now);
  }
  return std::sqrt(energy(largest) / energy(0.5 * alpha));
}

/// Speed ratio where the resultant of the impulses acts at a share of the half base from its
/// middle: angular momentum about that place is kept. Housner (1963) takes the edge, share 1: 1 -
/// 1.5 sin^2(alpha).
double ratio_for(double share) {
  const double s2 = std::pow(std::sin(alpha), 2), A = 4.0 / 3 - s2;
  return (A - share * s2) / (A + share * s2);
}

TEST(VB7_RockingBlock, speed_after_the_impact) {
  ASSERT_NEAR(ratio_for(1), 1 - 1.5 * std::pow(std::sin(alpha), 2), 1e-15);
  row("VB7", "block on two feet that rocks: speed after over before the first impact", ratio_for(1),
      speed_ratio(rocking_block(true)), 0.005, "");
}

/// A flat base has a vertex in its middle. While it turns about the old edge, that vertex is half
/// as deep as the new edge and has a quarter of its force: the resultant is at 0.8 of the half base
/// from the middle.
TEST(VB7_RockingBlock, a_flat_base_has_a_part_of_the_impulse_within_it) {
  const double flat = speed_ratio(rocking_block(false));
  row("VB7", "block on a flat base of three vertices that rocks: speed after over before",
      ratio_for(0.8), flat, 0.005, "");
  EXPECT_GT(flat, 1.01 * ratio_for(1));
}

/// Times at which the pieces of a row of dominoes lean by 0.05 rad [s]. They are 1 m high and 0.2 m
/// thick, 0.4 m apart.
/// @param push  angular speed of the first one about its edge at the start [rad/s]
std::vector<double> times_of_dominoes(double push, double dt) {
  const double height = 1, width = 0.2, period = width + 0.4, lean = 0.05;
  HardBody piece =
      hard_body(box_shape<2>({width, height}, 2000), {.friction = 0.3, .restitution = 0.3});
  piece.law.stiffness *= 0.1;
  const std::size_t count = 8;
  Scene scene(2, std::vector<HardBody>(count, piece), on_slope(2, 0), {ground(2)});
  scene.step.dt = dt;
  for (std::size_t k = 0; k < count; ++k) {
    scene.now.states[k].x = {period * static_cast<double>(k), 0.5 * height + 1e-9, 0};
  }
  scene.now.states[0].W = {0, 0, -push};
  scene.now.states[0].v = Vector<3>(0, 0, -push).cross(Vector<3>(-0.5 * width, 0.5 * height, 0));
  std::vector<double> times, before(count, 0.0);
  for (int n = 0; times.size() < count && n * dt < 4; ++n) {
    scene.advance();
    for (std::size_t k = 0; k < count; ++k) {
      const double now = -angle_of(scene.now.states[k]);
      if (k == times.size() && now > lean)
        times.push_back(dt * (n + (lean - before[k]) / (now - before[k])));
      before[k] = now;
    }
  }
  return times;
}

/// A row of dominoes falls at a speed of its own, which the push of the first one does not change
/// (Stronge 1987): there is no closed form, the runs are compared with each other.
TEST(VB12_Dominoes, the_wave_does_not_remember_its_push) {
  const auto gentle = times_of_dominoes(1, 2e-3), hard = times_of_dominoes(2, 2e-3),
             fine = times_of_dominoes(1, 1e-3);
  for (const auto* times : {&gentle, &hard, &fine}) ASSERT_EQ(times->size(), 8u);
  const auto last = [](const std::vector<double>& times) { return times[7] - times[6]; };
  row("VB12", "8 dominoes: time from the 7th to the 8th, pushed twice as fast", last(gentle),
      last(hard), 0.01, "s");
  row("VB12", "8 dominoes: time from the 7th to the 8th, half the step", last(gentle), last(fine),
      0.01, "s");
  EXPECT_GT(gentle[1] - gentle[0], 1.5 * (hard[1] - hard[0]));
}

}  // namespace
}  // namespace gabion::mpm
