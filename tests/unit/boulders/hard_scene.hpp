// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mpm_solver/boulders/boulder_shape.hpp"
#include "mpm_solver/boulders/hard_contact.hpp"

namespace gabion::mpm {

inline constexpr double g = 9.81;

template <int dim>
HardBody hard_body(const BoulderShape<dim>& shape, HardLaw law) {
  HardBody body{
      .name = "stone", .mass = shape.mass, .sphere = shape.sphere, .radius = shape.radius};
  body.axes.template head<dim>() = shape.axes;
  for (const auto& X : shape.surface.vertices) {
    body.vertices.emplace_back(Vector<3>::Zero()).template head<dim>() = X;
  }
  for (std::size_t f = 0; f < shape.surface.facets.size(); f += dim) {
    HardFacet facet = {-1, -1, -1};
    for (int k = 0; k < dim; ++k) facet[k] = shape.surface.facets[f + k];
    body.facets.push_back(facet);
  }
  law.stiffness = 1.5 * body.mass.mass * 100 / std::pow(0.01 * body.radius, 3);
  body.law = law;
  return body;
}

/// Level ground in the plane y = 0 (2D) or z = 0 (3D), in pieces, from -half to half.
inline Obstacle ground(int dim, int pieces = 7, double half = 20) {
  Obstacle o;
  if (dim == 2) {
    for (int k = 0; k <= pieces; ++k) o.start.emplace_back(half - 2 * half * k / pieces, 0, 0);
    for (int k = 0; k < pieces; ++k) o.facets.push_back({k, k + 1, -1});
  } else {
    for (int j = 0; j <= pieces; ++j) {
      for (int i = 0; i <= pieces; ++i) {
        o.start.emplace_back(2 * half * i / pieces - half, 2 * half * j / pieces - half, 0);
      }
    }
    const int n = pieces + 1;
    for (int j = 0; j < pieces; ++j) {
      for (int i = 0; i < pieces; ++i) {
        const int v = j * n + i;
        o.facets.push_back({v, v + 1, v + n + 1});
        o.facets.push_back({v, v + n + 1, v + n});
      }
    }
  }
  o.end = o.start;
  return o;
}

struct Scene {
  Scene(int dim_, std::vector<HardBody> bodies, const Vector<3>& gravity,
        std::vector<Obstacle> obstacles)
      : contact(dim_, bodies, gravity), down(gravity) {
    step.dt = 0.005;
    step.loads.resize(bodies.size());
    step.held.assign(bodies.size(), 0);
    step.obstacles = std::move(obstacles);
    now.states.resize(bodies.size());
  }
  HardContact::End advance() {
    HardContact::End end = contact.solve(now, step);
    now = {end.states, end.memories};
    return end;
  }
  void run(double time) {
    for (double t = 0; t < time - 1e-9; t += step.dt) advance();
  }
  // Energy of motion, weight and springs [J].
  double energy() const {
    double sum = contact.stored_energy(now.memories);
    for (std::size_t c = 0; c < now.states.size(); ++c) {
      const BodyMass& mass = contact.bodies()[c].mass;
      sum += kinetic_energy(mass, now.states[c]) - mass.mass * down.dot(now.states[c].x);
    }
    return sum;
  }
  HardContact contact;
  Vector<3> down;
  HardContact::Step step;
  HardContact::Start now;
};

/// Gravity for level ground that stands for a slope.
inline Vector<3> on_slope(int dim, double degrees) {
  const double angle = degrees * std::numbers::pi / 180;
  Vector<3> gravity(g * std::sin(angle), 0, 0);
  gravity[dim - 1] = -g * std::cos(angle);
  return gravity;
}

/// Three discs, the lower ones just apart: each has the normal force m g / (2 cos 30) of the upper
/// one; they stand with friction of at least tan 15 between them, tan(15) / 3 below.
/// @returns  largest speed after 3 s over sqrt(g R)
inline double pyramid_speed(double friction) {
  const double R = 0.5, gap = 1e-4;
  const std::vector<HardBody> bodies(3,
                                     hard_body(sphere_shape<2>(R, 2650), {.friction = friction}));
  Scene scene(2, bodies, on_slope(2, 0), {ground(2)});
  scene.now.states[0].x = {-R - gap, R, 0};
  scene.now.states[1].x = {R + gap, R, 0};
  scene.now.states[2].x = {0, R + std::sqrt(4 * R * R - std::pow(R + gap, 2)), 0};
  scene.run(3);
  double speed = 0;
  for (const BodyState& s : scene.now.states) speed = std::max(speed, s.v.norm());
  return speed / std::sqrt(g * R);
}

}  // namespace gabion::mpm
