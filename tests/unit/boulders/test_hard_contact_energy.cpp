// SPDX-License-Identifier: BSD-3-Clause
// Bodies of all shapes on surfaces of all facets: what moves, weighs and is stored is never more.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/unit/boulders/hard_scene.hpp"

namespace gabion::mpm::test_hard_contact_energy {
namespace {

struct Random {
  std::mt19937 generator;
  // A number in [low, high) with equal bits everywhere; those of std::uniform_real_distribution
  // depend on the library.
  double in(double low, double high) { return low + (high - low) * generator() / 4294967296.; }
  int below(int n) { return static_cast<int>(generator() % n); }
};

/// Ground that goes up and down by `height`, in facets of `size`, about 8 m by 8 m (2D: 12 m).
Obstacle rough_ground(int dim, double size, double height, Random& random) {
  const int pieces = std::min(dim == 2 ? 600 : 24, static_cast<int>((dim == 2 ? 12 : 8) / size));
  Obstacle o = ground(dim, pieces, 0.5 * size * pieces);
  for (Vector<3>& x : o.start) x[dim - 1] += random.in(-height, height);
  o.end = o.start;
  return o;
}

template <int dim>
BoulderShape<dim> some_shape(Random& random) {
  Vector<dim> size;
  for (double& s : size) s = random.in(0.4, 1.2);
  const int kind = random.below(dim == 2 ? 4 : 3);
  if (kind == 0) return sphere_shape<dim>(0.5 * size[0], 2650);
  if (kind == 1) return box_shape<dim>(size, 2650);
  if (kind == 2) return ellipsoid_shape<dim>(Vector<dim>(0.5 * size), 2650);
  ContactSurface<dim> polygon;
  for (std::int32_t k = 0; k < 5; ++k) {
    const double angle = 2 * M_PI * (k + random.in(-0.3, 0.3)) / 5, radius = random.in(0.3, 0.7);
    polygon.vertices.emplace_back(Vector<dim>::Zero()).template head<2>() =
        Vector<2>(radius * std::cos(angle), radius * std::sin(angle));
    polygon.facets.insert(polygon.facets.end(), {k, (k + 1) % 5});
  }
  return surface_shape(polygon, 2650);
}

struct Seen {
  int touched = 0;
  double sunk = 0;
};

template <int dim>
void run_some(int number, Seen& seen) {
  Random random{.generator = std::mt19937(number)};
  std::vector<HardBody> bodies;
  const double restitution = random.below(4) == 0 ? 1 : random.in(0, 1);
  const double friction = random.below(4) == 0 ? 0 : random.in(0, 1);
  for (int k = 0; k < 1 + random.below(2); ++k) {
    bodies.push_back(
        hard_body(some_shape<dim>(random), {.friction = friction, .restitution = restitution}));
    if (bodies.back().sphere > 0) bodies.back().law.rolling = random.in(0, 0.2);
  }
  const double size = std::pow(10, random.in(dim == 2 ? -1.7 : -0.4, 0.7));
  const double height = random.below(2) == 0 ? 0 : random.in(0, 0.2) * size;
  Scene scene(dim, bodies, on_slope(dim, random.in(0, 45)),
              {rough_ground(dim, size, height, random)});
  scene.step.dt = number % 3 == 0 ? 0.01 : 0.001;
  double up = height;
  for (std::size_t c = 0; c < bodies.size(); ++c) {
    BodyState& s = scene.now.states[c];
    up += bodies[c].radius + 0.01;
    s.x[dim - 1] = up;
    up += bodies[c].radius;
    s.v = Vector<3>(random.in(-5, 5), 0, 0);
    s.v[dim - 1] = random.in(-10, 0);
    if (dim == 3) s.v[1] = random.in(-3, 3);
    s.q = Eigen::AngleAxisd(random.in(-3, 3), Vector<3>::UnitZ());
    if (dim == 3) s.q = s.q * Eigen::AngleAxisd(random.in(-3, 3), Vector<3>::UnitX());
    const double spin = random.below(3) == 0 ? 30 : 3;
    s.W[2] = random.in(-spin, spin);
    if (dim == 3) s.W.head<2>() = Vector<2>(random.in(-spin, spin), random.in(-spin, spin));
  }
  double mass = 0;
  for (const HardBody& body : bodies) mass += body.mass.mass;
  double energy = scene.energy();
  // The scale is the energy of the bodies' fall and of their motion.
  const double scale = std::abs(energy) + mass * g * 10;
  for (double t = 0; t < (dim == 2 ? 0.2 : 0.1); t += scene.step.dt) {
    scene.advance();
    const double now = scene.energy();
    ASSERT_LT(now, energy + 1e-9 * scale) << dim << "D, case " << number << ", at " << t << " s";
    energy = now;
    seen.touched += scene.now.memories.empty() ? 0 : 1;
  }
}

TEST(HardContactEnergy, it_is_never_gained_in_the_plane) {
  Seen seen;
  for (int number = 0; number < 60; ++number) run_some<2>(number, seen);
  EXPECT_GT(seen.touched, 60);
}

TEST(HardContactEnergy, it_is_never_gained_in_space) {
  Seen seen;
  for (int number = 0; number < 12; ++number) run_some<3>(number, seen);
  EXPECT_GT(seen.touched, 12);
}

}  // namespace
}  // namespace gabion::mpm::test_hard_contact_energy
