// SPDX-License-Identifier: BSD-3-Clause
// Ellipsoids against closed forms of impacts, and against spheres.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/unit/boulders/hard_scene.hpp"

namespace gabion::mpm::test_hard_contact_ellipsoids {
namespace {

/// An ellipsoid whose impacts are so short that it does not turn in them.
template <int dim>
HardBody stiff(const BoulderShape<dim>& shape, const HardLaw& law) {
  HardBody body = hard_body(shape, law);
  body.law.stiffness *= 1e6;
  return body;
}

/// The half-space z < 0 (2D: y < 0), turned by q about the origin.
Obstacle turned_ground(int dim, const Eigen::Quaterniond& q) {
  Obstacle o = ground(dim, 3, 2);
  for (Vector<3>& x : o.start) x = q * x;
  o.end = o.start;
  return o;
}

struct Impact {
  Vector<3> v = Vector<3>::Zero(), spin = Vector<3>::Zero();
};

/// A frictionless impact at a normal n at the arm r: J = (1 + e) c / (1/m + n . (I^-1 (r x n)) x r)
/// with the closing speed c there.
Impact closed_form(const HardBody& body, const BodyState& s, const Vector<3>& r,
                   const Vector<3>& n) {
  const Matrix<3> R = s.q.toRotationMatrix();
  const Matrix<3> inverse = R * body.mass.inertia.inverse() * R.transpose();
  const double closing = -n.dot(s.v + s.spin().cross(r));
  const Vector<3> arm = r.cross(n);
  const double J =
      (1 + body.law.restitution) * closing / (1 / body.mass.mass + arm.dot(inverse * arm));
  return {.v = s.v + J / body.mass.mass * n, .spin = s.spin() + J * (inverse * arm)};
}

constexpr double fall = 1e-4;  // gap at the start over the speed [s]

/// The motion after an impact minus the closed form, over speed and speed over radius; all is
/// turned by q.
template <int dim>
double error_of_impact(const Vector<dim>& axes, const BodyState& start, double restitution,
                       const Eigen::Quaterniond& q) {
  const HardBody body =
      stiff(ellipsoid_shape<dim>(axes, 2650), {.friction = 0, .restitution = restitution});
  const Vector<3> n = q * Vector<3>::Unit(dim - 1);
  Scene scene(dim, {body}, Vector<3>::Zero(), {turned_ground(dim, q)});
  BodyState& s = scene.now.states[0];
  s = start;
  s.q = q * start.q;
  s.v = q * start.v;
  // It is placed such that it touches, and moved back by the time of the fall.
  const Ellipsoid shape(Vector<3>::Zero(), s.q, body.axes);
  const Vector<3> r = shape.support(-n);
  s.x = shape.extent(n) * n;
  const Impact right = closed_form(body, s, r, n);
  s.x -= fall * s.v;
  s.q = (s.q * Eigen::Quaterniond(Eigen::AngleAxisd(-fall * s.W.norm(), s.W.normalized())))
            .normalized();
  const double speed = s.v.norm();
  scene.step.dt = 2 * fall;
  scene.run(4 * fall);
  return std::max((scene.now.states[0].v - right.v).norm(),
                  body.radius * (scene.now.states[0].spin() - right.spin).norm()) /
         speed;
}

Eigen::Quaterniond about_z(double angle) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vector<3>::UnitZ()));
}

TEST(HardContactEllipsoids, an_ellipse_leaves_a_wall_as_its_lever_tells) {
  for (const double turned : {0., 0.5, -0.5, 2.}) {
    for (const double spin : {1e-9, 20., -20.}) {
      BodyState s;
      s.q = about_z(turned);
      s.v = {1, -6, 0};
      s.W = {0, 0, spin};
      for (const double e : {0.4, 1.}) {
        for (const double wall : {0., 1.2, -2.5}) {
          EXPECT_LT(error_of_impact<2>({0.3, 0.2}, s, e, about_z(wall)), 1e-3)
              << turned << " " << spin << " " << e << " " << wall;
        }
        EXPECT_LT(error_of_impact<2>({0.25, 0.25}, s, e, about_z(0.3)), 1e-3);
      }
    }
  }
}

TEST(HardContactEllipsoids, an_ellipsoid_leaves_a_wall_as_its_lever_tells) {
  const Eigen::Quaterniond walls[] = {
      Eigen::Quaterniond::Identity(),
      Eigen::Quaterniond(Eigen::AngleAxisd(1.1, Vector<3>(1, 2, -1).normalized()))};
  for (const auto& wall : walls) {
    for (const double spin : {1e-9, 15.}) {
      BodyState s;
      s.q = Eigen::AngleAxisd(0.5, Vector<3>(1, -1, 0.3).normalized());
      s.v = {1, 0.5, -6};
      s.W = spin * Vector<3>(0.5, -1, 0.7);
      EXPECT_LT(error_of_impact<3>({0.3, 0.2, 0.25}, s, 0.4, wall), 1e-3) << spin;
      EXPECT_LT(error_of_impact<3>({0.25, 0.25, 0.25}, s, 0.4, wall), 1e-3) << spin;
    }
  }
}

// The corner of a wall is the contact point, with the normal of the ellipse there.
TEST(HardContactEllipsoids, an_ellipse_meets_a_corner) {
  const HardBody body =
      stiff(ellipsoid_shape<2>({0.3, 0.2}, 2650), {.friction = 0, .restitution = 0.5});
  Obstacle corner;
  corner.start = {{1, -1, 0}, {0, 0, 0}, {-1, -1, 0}};
  corner.end = corner.start;
  corner.facets = {{0, 1, -1}, {1, 2, -1}};
  Scene scene(2, {body}, Vector<3>::Zero(), {corner});
  BodyState& s = scene.now.states[0];
  s.q = about_z(0.3);
  s.v = {0.5, -5, 0};
  const Vector<3> n = Vector<3>(0.2, 1, 0).normalized();
  const Vector<3> r = Ellipsoid(Vector<3>::Zero(), s.q, body.axes).support(-n);
  const Impact right = closed_form(body, s, r, n);
  s.x = -r - fall * s.v;
  scene.step.dt = 2 * fall;
  scene.run(4 * fall);
  EXPECT_LT((scene.now.states[0].v - right.v).norm(), 5e-3);
  EXPECT_LT((scene.now.states[0].spin() - right.spin).norm(), 5e-3 / 0.3);
}

// A ridge of two planes, whose edge the ellipsoid meets between its ends or, on a pyramid, at its
// tip.
TEST(HardContactEllipsoids, an_ellipsoid_meets_edges_and_tips) {
  const HardBody body =
      stiff(ellipsoid_shape<3>({0.3, 0.2, 0.25}, 2650), {.friction = 0, .restitution = 0.5});
  Obstacle ridge, pyramid;
  ridge.start = {{0, -1, 0}, {0, 1, 0}, {1, -1, -1}, {1, 1, -1}, {-1, -1, -1}, {-1, 1, -1}};
  ridge.facets = {{0, 2, 3}, {0, 3, 1}, {0, 1, 5}, {0, 5, 4}};
  pyramid.start = {{0, 0, 0}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}, {-1, -1, -1}};
  pyramid.facets = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}};
  for (Obstacle o : {ridge, pyramid}) {
    const bool is_ridge = o.start.size() == 6;
    o.end = o.start;
    Scene scene(3, {body}, Vector<3>::Zero(), {o});
    BodyState& s = scene.now.states[0];
    s.q = Eigen::AngleAxisd(0.4, Vector<3>(1, 2, 3).normalized());
    s.v = {0.5, 0.2, -5};
    const Vector<3> n = Vector<3>(0.2, is_ridge ? 0 : -0.1, 1).normalized();
    const Vector<3> r = Ellipsoid(Vector<3>::Zero(), s.q, body.axes).support(-n);
    const Impact right = closed_form(body, s, r, n);
    s.x = Vector<3>(0, is_ridge ? 0.137 : 0, 0) - r - fall * s.v;
    scene.step.dt = 2 * fall;
    scene.run(4 * fall);
    EXPECT_LT((scene.now.states[0].v - right.v).norm(), 5e-3) << is_ridge;
    EXPECT_LT((scene.now.states[0].spin() - right.spin).norm(), 5e-3 / 0.3) << is_ridge;
  }
}

// A plane is one plane, whatever its facets are; and a sphere is one, whatever its key.
template <int dim>
BodyState after(const BoulderShape<dim>& shape, int pieces) {
  HardBody body = hard_body(shape, {.friction = 0.6});
  Scene scene(dim, {body}, on_slope(dim, 0), {ground(dim, pieces, 2)});
  BodyState& s = scene.now.states[0];
  s.x = {0.01371, 0, 0};
  s.x[dim - 1] = 0.62;
  s.v = {3, 0, 0};
  s.v[dim - 1] = -4;
  s.q = Eigen::AngleAxisd(0.5, dim == 2 ? Vector<3>::UnitZ() : Vector<3>::UnitX());
  scene.run(0.2);
  return scene.now.states[0];
}

void expect_near(const BodyState& s, const BodyState& t, double bound) {
  EXPECT_LT((s.x - t.x).norm(), bound);
  EXPECT_LT((s.v - t.v).norm(), bound * t.v.norm());
  EXPECT_LT((s.W - t.W).norm(), bound * t.W.norm());
}

TEST(HardContactEllipsoids, a_plane_is_one_plane) {
  const auto ellipse = ellipsoid_shape<2>({0.5, 0.3}, 2650);
  for (const int pieces : {16, 400}) expect_near(after(ellipse, pieces), after(ellipse, 1), 1e-9);
  const auto stone = ellipsoid_shape<3>({0.5, 0.3, 0.4}, 2650);
  for (const int pieces : {8, 30}) expect_near(after(stone, pieces), after(stone, 1), 1e-9);
}

TEST(HardContactEllipsoids, equal_axes_are_a_sphere) {
  const auto disc = after(sphere_shape<2>(0.5, 2650), 7);
  expect_near(after(ellipsoid_shape<2>({0.5, 0.5}, 2650), 7), disc, 1e-10);
  const auto sphere = after(sphere_shape<3>(0.5, 2650), 7);
  expect_near(after(ellipsoid_shape<3>({0.5, 0.5, 0.5}, 2650), 7), sphere, 1e-10);
}

/// Two bodies that meet off their centres.
template <int dim>
void expect_conserved(const BoulderShape<dim>& first, const BoulderShape<dim>& second,
                      double offset) {
  const HardLaw law{.friction = 0, .restitution = 1};
  const std::vector<HardBody> bodies = {hard_body(first, law), hard_body(second, law)};
  Scene scene(dim, bodies, Vector<3>::Zero(), {});
  auto& s = scene.now.states;
  s[0].q = about_z(0.4);
  s[0].W = {0, 0, 3};
  s[1].x = {1.1, offset, 0};
  s[1].v = {-6, 0, 0};
  s[1].q = about_z(-0.7);
  if (dim == 3) {
    s[1].q = s[1].q * Eigen::Quaterniond(Eigen::AngleAxisd(0.8, Vector<3>::UnitX()));
    s[0].W = {1, -2, 3};
  }
  const auto sums = [&] {
    Impact sum;
    for (int c = 0; c < 2; ++c) {
      const BodyMass& mass = bodies[c].mass;
      sum.v += mass.mass * s[c].v;
      sum.spin += mass.mass * s[c].x.cross(s[c].v) + angular_momentum(mass, s[c]);
    }
    return sum;
  };
  const Impact before = sums();
  const double energy = scene.energy(), angle = s[1].W.norm();
  const Vector<3> v = s[0].v;
  scene.run(0.2);
  EXPECT_LT((sums().v - before.v).norm(), 1e-12 * before.v.norm());
  EXPECT_LT((sums().spin - before.spin).norm(), 1e-11 * before.v.norm());
  EXPECT_NEAR(scene.energy() / energy, 1, 1e-11);
  EXPECT_GT((s[0].v - v).norm(), 0.5);
  EXPECT_NE(s[1].W.norm(), angle);
  EXPECT_TRUE(scene.now.memories.empty());
}

TEST(HardContactEllipsoids, pairs_keep_momentum_and_energy) {
  for (const double offset : {0., 0.2, -0.3}) {
    expect_conserved(ellipsoid_shape<2>({0.5, 0.3}, 2650), ellipsoid_shape<2>({0.4, 0.2}, 2000),
                     offset);
    expect_conserved(ellipsoid_shape<2>({0.5, 0.3}, 2650), box_shape<2>({0.7, 0.5}, 2000), offset);
    expect_conserved(ellipsoid_shape<3>({0.5, 0.3, 0.4}, 2650),
                     ellipsoid_shape<3>({0.4, 0.2, 0.3}, 2000), offset);
    expect_conserved(ellipsoid_shape<3>({0.5, 0.3, 0.4}, 2650), box_shape<3>({0.7, 0.5, 0.6}, 2000),
                     offset);
  }
}

// A sphere with another one, either of them given as an ellipsoid. Two directions follow the gap:
// to second order in the rotation of a substep that of two centres is another one.
TEST(HardContactEllipsoids, pairs_of_equal_axes_are_spheres) {
  const auto run = [](bool first, bool second) {
    const HardLaw law{.friction = 0.4};
    const auto body = [&](bool ellipsoid, double R) {
      return hard_body(ellipsoid ? ellipsoid_shape<3>({R, R, R}, 2650) : sphere_shape<3>(R, 2650),
                       law);
    };
    Scene scene(3, {body(first, 0.5), body(second, 0.3)}, Vector<3>::Zero(), {});
    scene.now.states[1].x = {0.9, 0.3, 0.1};
    scene.now.states[1].v = {-6, 0, 0};
    scene.now.states[1].W = {1, 2, 3};
    scene.run(0.1);
    return scene.now.states;
  };
  const auto spheres = run(false, false);
  for (const auto& [first, second] : {std::pair(true, false), {false, true}, {true, true}}) {
    const auto states = run(first, second);
    for (int c = 0; c < 2; ++c) expect_near(states[c], spheres[c], 1e-9);
  }
}

// On its flat side an ellipsoid swings about its rest with the frequency of its centre above the
// ground, sqrt(m g (R - b) / (I + m b^2)), with R = a^2 / b of its curvature.
TEST(HardContactEllipsoids, an_ellipse_rocks_on_its_flat_side) {
  const double a = 0.5, b = 0.3;
  const HardBody body =
      hard_body(ellipsoid_shape<2>({a, b}, 2650), {.friction = 5, .restitution = 1});
  const double I = body.mass.inertia(2, 2), m = body.mass.mass;
  Scene scene(2, {body}, on_slope(2, 0), {ground(2)});
  scene.step.dt = 1e-3;
  BodyState& s = scene.now.states[0];
  const double angle = 0.02;
  s.q = about_z(angle);
  s.x[1] =
      std::hypot(a * std::sin(angle), b * std::cos(angle)) - std::sqrt(m * g / body.law.stiffness);
  const double period =
      2 * std::numbers::pi * std::sqrt((I + m * b * b) / (m * g * (a * a / b - b)));
  scene.run(period);
  EXPECT_NEAR(2 * scene.now.states[0].q.z(), angle, 0.01 * angle);
  EXPECT_LT(std::abs(scene.now.states[0].W[2]), 0.05 * angle * 2 * std::numbers::pi / period);
}

// A mirrored scene has the mirrored motion.
TEST(HardContactEllipsoids, mirrored_scenes_are_mirrored) {
  const auto run = [](double side) {
    const HardBody body = hard_body(ellipsoid_shape<2>({0.5, 0.3}, 2650), {.friction = 0.5});
    Scene scene(2, {body}, on_slope(2, 0), {ground(2)});
    BodyState& s = scene.now.states[0];
    s.x = {side * 0.1, 0.6, 0};
    s.v = {side * 2, -3, 0};
    s.q = about_z(side * 0.6);
    s.W = {0, 0, side * 4};
    scene.run(0.5);
    return scene.now.states[0];
  };
  const BodyState right = run(1), left = run(-1);
  EXPECT_NEAR(right.x[0], -left.x[0], 1e-9);
  EXPECT_NEAR(right.x[1], left.x[1], 1e-9);
  EXPECT_NEAR(right.W[2], -left.W[2], 1e-8);
}

TEST(HardContactEllipsoids, the_deepest_overlap_is_named) {
  const std::vector<HardBody> bodies(2, hard_body(ellipsoid_shape<2>({0.5, 0.3}, 2650), {}));
  const HardContact contact(2, bodies, Vector<3>::Zero());
  std::vector<BodyState> states(2);
  states[0].x = {0, 0.31, 0};
  states[1].x = {0.95, 0.31, 0};
  const auto two = contact.deepest_overlap(states, {ground(2)});
  EXPECT_NEAR(two.depth, 0.05, 1e-12);
  EXPECT_EQ(two.other, 1);
  states[1].x = {3, 0.2, 0};
  const auto wall = contact.deepest_overlap(states, {ground(2)});
  EXPECT_NEAR(wall.depth, 0.1, 1e-12);
  EXPECT_EQ(wall.body, 1);
  EXPECT_EQ(wall.other, 2);
}

}  // namespace
}  // namespace gabion::mpm::test_hard_contact_ellipsoids
