// SPDX-License-Identifier: BSD-3-Clause
// Rigid bodies that touch what is hard, against closed forms of rigid bodies.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mpm_solver/boulders/ellipsoid.hpp"
#include "tests/support/verification_row.hpp"
#include "tests/unit/boulders/hard_scene.hpp"

namespace gabion::mpm {
namespace {

using test::Measure;
using test::verify;

constexpr double pi = std::numbers::pi;

// Depth at which the ground carries the weight.
double rest_depth(const HardBody& body, double weight) {
  return std::sqrt(body.mass.mass * weight / body.law.stiffness);
}

void row(const std::string& id, const std::string& what, double exact, double computed,
         double bound, const std::string& unit) {
  verify(
      {.id = id, .what = what, .exact = exact, .computed = computed, .bound = bound, .unit = unit});
}

void bounded(const std::string& id, const std::string& what, double computed, double bound,
             const std::string& unit) {
  verify({.id = id,
          .what = what,
          .exact = 0,
          .computed = computed,
          .measure = Measure::absolute_error,
          .bound = bound,
          .unit = unit});
}

template <int dim>
Scene sphere_on_ground(double degrees, const HardLaw& law) {
  const HardBody body = hard_body(sphere_shape<dim>(0.5, 2650), law);
  Scene scene(dim, {body}, on_slope(dim, degrees), {ground(dim)});
  scene.now.states[0].x[0] = -5;
  scene.now.states[0].x[dim - 1] = 0.5 - rest_depth(body, g * std::cos(degrees * pi / 180));
  return scene;
}

/// A body that rolls down a slope has the acceleration g sin / (1 + J / (m R^2)); with less
/// friction than tan / (1 + m R^2 / J) it slides: g (sin - mu cos), R dW/dt = mu g cos m R^2 / J.
TEST(VB4_Rolling, balls_on_a_slope) {
  for (const double friction : {0.21, 0.5}) {
    Scene disc = sphere_on_ground<2>(30, {.friction = friction});
    disc.run(1);
    row("VB4", fmt::format("disc on 30 deg, friction {}, rolls: speed after 1 s", friction),
        2. / 3 * g * 0.5, disc.now.states[0].v[0], 1e-4, "m/s");
  }
  Scene sphere = sphere_on_ground<3>(30, {.friction = 0.5});
  sphere.run(1);
  row("VB4", "sphere on 30 deg, rolls: speed after 1 s", 5. / 7 * g * 0.5,
      sphere.now.states[0].v[0], 1e-4, "m/s");
  Scene sliding = sphere_on_ground<2>(30, {.friction = 0.1});
  sliding.run(1);
  const BodyState& end = sliding.now.states[0];
  row("VB4", "disc on 30 deg, friction 0.1, slides: speed after 1 s",
      g * (0.5 - 0.1 * std::sqrt(0.75)), end.v[0], 1e-9, "m/s");
  row("VB4", "disc on 30 deg, friction 0.1, slides: R W after 1 s", 2 * 0.1 * g * std::sqrt(0.75),
      0.5 * end.spin().norm(), 1e-9, "m/s");
}

/// A body that slides on level ground ends in rolling, with v_0 / (1 + J / (m R^2)).
TEST(VB5_SlidingStart, balls_on_level_ground) {
  Scene disc = sphere_on_ground<2>(0, {.friction = 0.4});
  disc.now.states[0].v[0] = 3;
  disc.run(1);
  row("VB5", "disc of 3 m/s, friction 0.4: speed when it rolls", 2, disc.now.states[0].v[0], 5e-4,
      "m/s");
  Scene sphere = sphere_on_ground<3>(0, {.friction = 0.4});
  sphere.now.states[0].v[0] = 3;
  sphere.run(1);
  row("VB5", "sphere of 3 m/s, friction 0.4: speed when it rolls", 15. / 7,
      sphere.now.states[0].v[0], 5e-4, "m/s");
}

TEST(VB6_Pyramid, stands_by_friction) {
  const double least = std::tan(15 * pi / 180);
  bounded("VB6", "pyramid of discs, friction tan 15 + 5 %: speed after 3 s over sqrt(g R)",
          pyramid_speed(1.05 * least), 1e-6, "");
  EXPECT_GT(pyramid_speed(0.95 * least), 1e-3);  // falls
}

/// A free body that spins about its middle axis flips; energy and angular momentum stay.
TEST(VB7_Tumbling, flips_keep_energy_and_momentum) {
  BodyMass body;
  body.mass = 1;
  body.inertia = Vector<3>(1, 2, 3).asDiagonal();
  BodyState state;
  state.W = {0.01, 2, 0};
  const double energy = kinetic_energy(body, state);
  const Vector<3> momentum = angular_momentum(body, state);
  for (int k = 0; k < 20000; ++k) state = advance(body, state, {}, 0.05);
  bounded("VB7",
          "free body about its middle axis, 20000 steps: energy over its initial value, minus 1",
          kinetic_energy(body, state) / energy - 1, 1e-11, "");
  bounded("VB7", "free body about its middle axis, 20000 steps: change of angular momentum",
          (angular_momentum(body, state) - momentum).norm() / momentum.norm(), 1e-11, "");
}

/// A frictionless elastic block that drops on its corner keeps its energy; others lose.
TEST(VB7_Tumbling, a_block_dropped_on_its_corner) {
  for (const bool elastic : {true, false}) {
    const HardBody block =
        hard_body(box_shape<2>({1, 0.5}, 2000),
                  {.friction = elastic ? 0 : 0.4, .restitution = elastic ? 1 : 0.5});
    Scene scene(2, {block}, on_slope(2, 0), {ground(2)});
    scene.now.states[0].x = {0.3, 1.2, 0};
    scene.now.states[0].q = Eigen::AngleAxisd(0.5, Vector<3>::UnitZ());
    const double first = scene.energy();
    double last = first, gain = 0;
    for (int k = 0; k < 400; ++k) {
      scene.advance();
      gain = std::max(gain, (scene.energy() - last) / first);
      last = scene.energy();
    }
    if (elastic) {
      bounded("VB7",
              "block on its corner, elastic, no friction: energy over its initial value, "
              "minus 1, 2 s",
              last / first - 1, 1e-9, "");
    } else {
      bounded("VB7",
              "block on its corner, e 0.5, friction 0.4: largest gain of a step over the initial "
              "energy",
              gain, 1e-12, "");
    }
  }
}

/// An ellipse that rolls over level ground, and leaves it at its speed, gains no energy in any
/// step.
TEST(VB12_RollingEllipse, gains_no_energy) {
  const HardBody body =
      hard_body(ellipsoid_shape<2>({0.6, 0.4}, 2650), {.friction = 5, .restitution = 1});
  Scene scene(2, {body}, on_slope(2, 0), {ground(2)});
  scene.step.dt = 2e-3;
  scene.now.states[0].x = {-3, 0.4 + 1e-3, 0};
  scene.now.states[0].v = {2.5, 0, 0};
  scene.now.states[0].W = {0, 0, -2.5 / 0.4};
  const double first = scene.energy();
  double most = 0;
  for (int k = 0; k < 1000; ++k) {
    scene.advance();
    most = std::max(most, scene.energy() - first);
  }
  bounded("VB12", "ellipse that rolls and bounces, 2 s: largest gain by m g a",
          most / (body.mass.mass * g * 0.6), 1e-10, "");
}

/// A sphere hits a wall head on: a spring of the force stiffness d^2 has its peak at the depth
/// (3 m v^2 / (2 stiffness))^(1/3), so that it grows by v^(4/3); the impulse is m (1 + e) v.
TEST(VB11_Impact, peak_and_impulse_of_a_sphere_at_a_wall) {
  for (const double speed : {1.0, 4.0, 16.0}) {
    for (const double restitution : {1.0, 0.5}) {
      const HardBody body =
          hard_body(sphere_shape<3>(0.5, 2650), {.friction = 0, .restitution = restitution});
      Scene scene(3, {body}, Vector<3>::Zero(), {ground(3)});
      scene.now.states[0].x = {0, 0, 0.5};
      scene.now.states[0].v = {0, 0, -speed};
      const double mass = body.mass.mass, k = body.law.stiffness;
      const double depth = std::cbrt(1.5 * mass * speed * speed / k), peak = k * depth * depth;
      scene.step.dt = 0.002 * depth / speed;
      double most = 0;
      for (int n = 0; n < 5000 && (n == 0 || scene.now.states[0].x[2] < 0.5); ++n) {
        const double before = scene.now.states[0].v[2];
        scene.advance();
        most = std::max(most, mass * (scene.now.states[0].v[2] - before) / scene.step.dt);
      }
      const auto what =
          fmt::format("sphere of {} m/s at a wall, restitution {}: ", speed, restitution);
      row("VB11", what + "peak of the force", peak, most, 1e-3, "N");
      row("VB11", what + "impulse", mass * (1 + restitution) * speed,
          mass * (scene.now.states[0].v[2] + speed), 1e-3, "N s");
    }
  }
}

/// An ellipse that meets a plane off its centre of mass.
struct EccentricImpact {
  HardBody body;
  Vector<3> v, r;  // speed of the centre before it [m/s], arm of the contact point [m]
  double spin = 0;

  EccentricImpact(double friction, const Vector<3>& speed, double angular_speed)
      : body(hard_body(ellipsoid_shape<2>({0.6, 0.4}, 2650),
                       {.friction = friction, .restitution = 0.5})),
        v(speed),
        spin(angular_speed) {
    body.law.stiffness *= 1e8;  // it does not turn meanwhile
    r = Ellipsoid(Vector<3>::Zero(), turned(), body.axes).support(-Vector<3>::UnitY());
  }
  static Eigen::Quaterniond turned() {
    return Eigen::Quaterniond(Eigen::AngleAxisd(0.6, Vector<3>::UnitZ()));
  }
  // The impulse P of the ground on it from 0 to the end changes the velocity of the contact point
  // by M P.
  Matrix<2> mobility() const {
    const double m = body.mass.mass, I = body.mass.inertia(2, 2);
    Matrix<2> M;
    M << 1 / m + r[1] * r[1] / I, -r[0] * r[1] / I, -r[0] * r[1] / I, 1 / m + r[0] * r[0] / I;
    return M;
  }
  Vector<2> at_contact() const { return {v[0] - spin * r[1], v[1] + spin * r[0]}; }
  BodyState after() const {
    constexpr double fall = 1e-5;
    Scene scene(2, {body}, Vector<3>::Zero(), {ground(2)});
    BodyState& s = scene.now.states[0];
    s.q = turned() * Eigen::Quaterniond(Eigen::AngleAxisd(-fall * spin, Vector<3>::UnitZ()));
    s.x = Vector<3>(0, -r[1], 0) - fall * v;
    s.v = v;
    s.W = {0, 0, spin};
    scene.step.dt = 2 * fall;
    scene.run(4 * fall);
    return scene.now.states[0];
  }
  void rows(const std::string& what, const Vector<2>& P, double bound,
            const std::string& limitation = "") const {
    const BodyState end = after();
    const double m = body.mass.mass, I = body.mass.inertia(2, 2);
    const auto add = [&](const char* name, double exact, double computed, const char* unit) {
      verify({.id = "VB11",
              .what = "ellipse on a plane, " + what + ": " + name,
              .exact = exact,
              .computed = computed,
              .measure = Measure::absolute_error,
              .bound = bound * (unit[0] == 'm' ? v.norm() : v.norm() / 0.6),
              .unit = unit,
              .limitation = limitation});
    };
    add("speed along it after the impact", v[0] + P[0] / m, end.v[0], "m/s");
    add("speed off it after the impact", v[1] + P[1] / m, end.v[1], "m/s");
    add("angular speed after the impact", spin + (r[0] * P[1] - r[1] * P[0]) / I, end.W[2],
        "rad/s");
  }
};

/// Impulse and angular momentum with a restitution e of the normal speed at the contact point.
TEST(VB11_Impact, an_ellipse_leaves_a_plane_off_its_centre) {
  const EccentricImpact smooth(0, {2, -5, 0}, 3);
  const double closing = -smooth.at_contact()[1];
  smooth.rows("no friction", Vector<2>(0, 1.5 * closing / smooth.mobility()(1, 1)), 1e-3);
  // It slides throughout: P = N (-mu, 1).
  const EccentricImpact slides(0.2, {20, -5, 0}, 3);
  const Vector<2> way(-0.2, 1);
  const Vector<2> change = slides.mobility() * way;
  slides.rows("friction 0.2, slides", -1.5 * slides.at_contact()[1] / change[1] * way, 1e-3);
}

/// With much friction the contact point of a rigid body would stay where it is. The tangential
/// spring gives back a part of its energy, as an elastic body does (Maw, Barber and Fawcett 1976).
TEST(VB11_Impact, an_ellipse_that_sticks) {
  const EccentricImpact sticks(5, {2, -5, 0}, 3);
  const Vector<2> c = sticks.at_contact();
  const Vector<2> P = sticks.mobility().inverse() * Vector<2>(-c[0], -1.5 * c[1]);
  sticks.rows("friction 5, sticks", P, 0.3,
              "the tangential spring is elastic, the contact point goes back a part of its way");
}

}  // namespace
}  // namespace gabion::mpm
