// SPDX-License-Identifier: BSD-3-Clause
// Impacts with friction, units, flat ellipsoids and the order of their axes.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "mpm_solver/boulders/boulder_law_config.hpp"
#include "mpm_solver/boulders/ellipsoid.hpp"
#include "tests/unit/boulders/hard_scene.hpp"

namespace gabion::mpm::test_ellipsoid_impacts {
namespace {

Eigen::Quaterniond about_z(double angle) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vector<3>::UnitZ()));
}

struct Impulse {
  double normal = 0, tangential = 0;  // on the body, over its mass [m/s]
};

/// The impulse of level ground on an ellipse that comes with a speed to the right and down.
/// @param stiffer  factor of the stiffness, large enough that the ellipse does not turn meanwhile
Impulse impulse_on(const HardLaw& law, const Vector<2>& axes, double angle, const Vector<2>& v,
                   double stiffer) {
  HardBody body = hard_body(ellipsoid_shape<2>(axes, 2650), law);
  body.law.stiffness *= stiffer;
  Scene scene(2, {body}, Vector<3>::Zero(), {ground(2, 3, 2)});
  BodyState& s = scene.now.states[0];
  s.q = about_z(angle);
  const double fall = 1e-4;
  s.x[1] = Ellipsoid(Vector<3>::Zero(), s.q, body.axes).extent(Vector<3>::UnitY()) - fall * v[1];
  s.v.head<2>() = v;
  scene.step.dt = 2 * fall;
  scene.run(4 * fall);
  EXPECT_TRUE(scene.now.memories.empty());
  return {.normal = scene.now.states[0].v[1] - v[1], .tangential = scene.now.states[0].v[0] - v[0]};
}

/// While the contact point slides to the right, the force is N (-mu, 1): with the arm r the impulse
/// J of N is (1 + e) c / (1/m + r_x (r_x + mu r_y) / I).
TEST(EllipsoidImpacts, a_point_that_slides_has_coulombs_impulse) {
  const Vector<2> v(12, -4);
  for (const double angle : {0., 0.5, -0.4}) {
    for (const double friction : {0.1, 0.3}) {
      for (const double stiffer : {1e5, 1e8}) {
        const HardLaw law{.friction = friction, .restitution = 0.5};
        const Vector<2> axes(0.3, 0.2);
        const auto shape = ellipsoid_shape<2>(axes, 2650);
        const Vector<3> r = Ellipsoid(Vector<3>::Zero(), about_z(angle), {axes[0], axes[1], 0})
                                .support(-Vector<3>::UnitY());
        const double m = shape.mass.mass, I = shape.mass.inertia(2, 2);
        const double exact = 1.5 * 4 / (1 + m / I * r[0] * (r[0] + friction * r[1]));
        const Impulse found = impulse_on(law, axes, angle, v, stiffer);
        EXPECT_NEAR(found.normal, exact, 2e-3 * exact) << angle << " " << friction;
        EXPECT_NEAR(found.tangential, -friction * found.normal, 1e-3 * friction * exact)
            << angle << " " << friction << " " << stiffer;
      }
    }
  }
}

/// Friction of an impact depends on the direction of the speed, not on its size or the stiffness.
TEST(EllipsoidImpacts, friction_does_not_depend_on_stiffness_and_speed) {
  for (const double friction : {0.2, 1., 5.}) {
    const HardLaw law{.friction = friction, .restitution = 0.5};
    const auto share = [&](double speed, double stiffer) {
      return impulse_on(law, {0.3, 0.2}, 0.3, Vector<2>(3, -4) * speed, stiffer).tangential / speed;
    };
    const double first = share(1, 1e6);
    EXPECT_NEAR(share(1, 1e9), first, 0.05 * std::abs(first)) << friction;
    EXPECT_NEAR(share(4, 1e6), first, 0.05 * std::abs(first)) << friction;
  }
}

/// Powers of two as units of length and time, which keep speeds, and of mass.
template <int dim>
BodyState in_units(double length, double mass) {
  Vector<dim> axes;
  for (int d = 0; d < dim; ++d) axes[d] = (0.5 - 0.1 * d) * length;
  const HardLaw law{.friction = 0.4, .restitution = 0.5};
  HardBody body = hard_body(ellipsoid_shape<dim>(axes, 2650 * mass / std::pow(length, dim)), law);
  // Of a power of a number only the exact factor is free of rounding.
  body.law.stiffness =
      mass / std::pow(length, 3) *
      hard_body(ellipsoid_shape<dim>(Vector<dim>(axes / length), 2650), law).law.stiffness;
  Scene scene(dim, {body, body}, on_slope(dim, 10) / length, {ground(dim, 5, 2 * length)});
  scene.step.dt *= length;
  for (int c = 0; c < 2; ++c) {
    BodyState& s = scene.now.states[c];
    s.x[0] = 0.1 * length;
    s.x[dim - 1] = (0.55 + 1.1 * c) * length;
    s.v = Vector<3>(3, 0, 0);
    s.v[dim - 1] = -4;
    s.q = Eigen::AngleAxisd(0.5, dim == 2 ? Vector<3>(0, 0, 1) : Vector<3>(2, 1, 2) / 3);
    s.W = (dim == 2 ? Vector<3>(0, 0, 5) : Vector<3>(1, 2, 3)) / length;
  }
  for (int k = 0; k < 40; ++k) scene.advance();
  BodyState end = scene.now.states[0];
  end.x /= length;
  end.W *= length;
  return end;
}

template <int dim>
void expect_free_of_units() {
  const BodyState right = in_units<dim>(1, 1);
  for (const auto& [length, mass] : {std::array{8., 1.}, {1. / 1024, 1.}, {1., 1. / 4096}}) {
    const BodyState end = in_units<dim>(length, mass);
    EXPECT_LT((end.x - right.x).norm(), 1e-13) << length << " " << mass;
    EXPECT_LT((end.v - right.v).norm(), 1e-12) << length << " " << mass;
    EXPECT_LT((end.W - right.W).norm(), 1e-12) << length << " " << mass;
  }
}

TEST(EllipsoidImpacts, units_do_not_matter) {
  expect_free_of_units<2>();
  expect_free_of_units<3>();
}

/// Axes in another order and an orientation that undoes it are the same body.
TEST(EllipsoidImpacts, axes_may_come_in_any_order) {
  const auto run = [](const Vector<3>& axes, const Matrix<3>& order) {
    const HardBody body = hard_body(ellipsoid_shape<3>(axes, 2650), {.friction = 0.4});
    Scene scene(3, {body, body}, on_slope(3, 0), {ground(3)});
    for (int c = 0; c < 2; ++c) {
      BodyState& s = scene.now.states[c];
      s.x = {0.05 * c, 0.02, 0.55 + 1.05 * c};
      s.v = {2, 0.5, -5};
      s.q = Eigen::Quaterniond(Eigen::AngleAxisd(0.6, Vector<3>(2, 1, 2) / 3)) *
            Eigen::Quaterniond(order);
      s.W = order.transpose() * Vector<3>(1, 2, 3);
    }
    scene.run(0.1);
    return scene.now.states[0];
  };
  const BodyState right = run({0.5, 0.4, 0.3}, Matrix<3>::Identity());
  for (const std::array<int, 3>& order :
       {std::array{1, 2, 0}, {2, 0, 1}, {1, 0, 2}, {0, 2, 1}, {2, 1, 0}}) {
    Matrix<3> turn = Matrix<3>::Zero();
    Vector<3> axes;
    for (int d = 0; d < 3; ++d) {
      turn(order[d], d) = 1;
      axes[d] = 0.5 - 0.1 * order[d];
    }
    if (turn.determinant() < 0) turn.col(2) *= -1;
    const BodyState end = run(axes, turn);
    EXPECT_LT((end.x - right.x).norm(), 1e-8) << order[0] << order[1] << order[2];
    EXPECT_LT((end.v - right.v).norm(), 1e-7) << order[0] << order[1] << order[2];
    EXPECT_LT((end.spin() - right.spin()).norm(), 1e-6) << order[0] << order[1] << order[2];
  }
}

/// An ellipsoid that falls on its flat side.
template <int dim>
Scene fall_of(const BoulderShape<dim>& shape, double speed, double stiffness) {
  HardBody body = hard_body(shape, {.friction = 0.4, .restitution = 0.5});
  body.law.stiffness = stiffness;
  Scene scene(dim, {body}, on_slope(dim, 0), {ground(dim)});
  scene.step.dt = 1e-3;
  scene.now.states[0].x[dim - 1] = shape.axes[dim - 1] + 0.01;
  scene.now.states[0].v[dim - 1] = -speed;
  return scene;
}

TEST(EllipsoidImpacts, a_flat_one_with_the_usual_stiffness_comes_back) {
  const auto plate = ellipsoid_shape<2>({1, 0.05}, 2650);
  const auto lens = ellipsoid_shape<3>({0.5, 0.4, 0.05}, 2650);
  Scene in_plane = fall_of(plate, 30, usual_stiffness(plate));
  Scene in_space = fall_of(lens, 30, usual_stiffness(lens));
  for (Scene* scene : {&in_plane, &in_space}) {
    const double energy = scene->energy();
    scene->run(0.01);
    EXPECT_NEAR(scene->now.states[0].v.norm(), 15, 0.1);
    EXPECT_LT(scene->energy(), energy);
  }
}

TEST(EllipsoidImpacts, the_usual_stiffness_of_equal_axes_is_that_of_a_sphere) {
  EXPECT_EQ(usual_stiffness(ellipsoid_shape<3>({0.5, 0.5, 0.5}, 2650)),
            usual_stiffness(sphere_shape<3>(0.5, 2650)));
}

/// Too soft bodies once passed through each other and through the ground without a word.
TEST(EllipsoidImpacts, what_would_pass_through_is_refused) {
  const auto refused = [](Scene scene, const std::string& other) {
    try {
      scene.run(0.05);
    } catch (const ConvergenceError& error) {
      const std::string text = error.what();
      EXPECT_NE(text.find("boulder \"stone\" is "), std::string::npos) << text;
      EXPECT_NE(text.find("deep in " + other), std::string::npos) << text;
      return true;
    }
    return false;
  };
  const auto plate = ellipsoid_shape<2>({1, 0.05}, 2650);
  EXPECT_TRUE(refused(fall_of(plate, 30, 1e9), "a surface"));
  EXPECT_TRUE(refused(fall_of(ellipsoid_shape<3>({0.5, 0.4, 0.05}, 2650), 30, 1e9), "a surface"));
  const HardBody lens = hard_body(plate, {.friction = 0});
  HardBody ball = hard_body(sphere_shape<2>(0.3, 2650), {.friction = 0});
  ball.law.stiffness *= 1e-4;
  for (const bool first : {true, false}) {
    Scene scene(2, first ? std::vector{ball, lens} : std::vector{lens, ball}, Vector<3>::Zero(),
                {});
    scene.step.held[first ? 1 : 0] = 1;
    scene.now.states[first ? 0 : 1].x = {0, 0.36, 0};
    scene.now.states[first ? 0 : 1].v = {0, -20, 0};
    EXPECT_TRUE(refused(std::move(scene), "\"stone\"")) << first;
  }
}

}  // namespace
}  // namespace gabion::mpm::test_ellipsoid_impacts
