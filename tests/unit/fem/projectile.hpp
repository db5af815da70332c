// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>

#include "tests/unit/fem/fem_scene.hpp"

namespace gabion::test {

/// A mass that flies in x against the surface "wall" of a structure, with a penalty between the
/// mass and the mean displacement of the surface. Its motion is exact for a force that is constant
/// in a step, as soil has it.
struct Projectile {
  double mass = 1, v = 1, gap = 0;  // [kg, m/s, m]
  double penalty = 1;               // [N/m]
};

/// Shares of the energy after an impact, over that of the projectile at the start.
struct ImpactEnergy {
  double largest = 0;        ///< of projectile, penalty and structure together
  double with_damping = 0;   ///< the same with `damping_work`
  double least_damping = 0;  ///< smallest change of `damping_work` in a step
  double largest_force = 0;  ///< [N]
  double in_structure = 0;   ///< largest energy of the structure beyond its external_work
};

/// @param damped  the structure has a probe `damping_work`
inline ImpactEnergy impact(Solver& solver, Projectile p, double dt, int steps, bool damped) {
  solver.set_force_kinds({{"wall", ForceKind::step_mean}});
  const auto count = static_cast<int>(solver.interfaces()[0].num_vertices());
  const double start = 0.5 * p.mass * p.v * p.v, u_start = -p.gap;
  double u = u_start, damping = 0;
  ImpactEnergy result;
  for (int n = 1; n <= steps; ++n) {
    const StepRequest request{n, 0, (n - 1) * dt, dt};
    const auto surface_at = [&](double force) {
      std::vector<double> forces(2 * count, 0.0);
      for (int i = 0; i < count; ++i) forces[2 * i] = force / count;
      InterfaceValues sent;
      solver.solve_step(request, {{"wall", forces}}, sent);
      double mean = 0;
      for (int i = 0; i < count; ++i) mean += sent.at("wall")[2 * i] / count;
      return mean;
    };
    const double unit = start / (std::abs(p.v) * dt + 1e-3);  // of the size of what comes
    const double free = surface_at(0), slope = (surface_at(unit) - free) / unit;
    const double own = 0.5 * dt * dt / p.mass;
    const double open = u + dt * p.v - free;
    const double force = p.penalty * std::max(open, 0.0) / (1 + p.penalty * (slope + own));
    const double at = surface_at(force);
    solver.accept_step(request, true);
    u += dt * p.v - own * force;
    p.v -= dt * force / p.mass;
    const double structure = probe(solver, "kinetic_energy") + probe(solver, "elastic_energy");
    const double all =
        structure + 0.5 * p.mass * p.v * p.v + 0.5 * p.penalty * std::pow(std::max(u - at, 0.0), 2);
    result.largest = std::max(result.largest, all / start);
    result.in_structure =
        std::max(result.in_structure, (structure - probe(solver, "external_work")) / start);
    result.largest_force = std::max(result.largest_force, force);
    if (!damped) continue;
    const double lost = probe(solver, "damping_work");
    result.with_damping = std::max(result.with_damping, (all + lost) / start);
    result.least_damping = std::min(result.least_damping, (lost - damping) / start);
    damping = lost;
  }
  return result;
}

}  // namespace gabion::test
