// SPDX-License-Identifier: BSD-3-Clause
// Soil that softens: the work of a slip surface and the load of a footing on several grids; clay
// that is remoulded and runs out.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {
namespace {

constexpr double peak = 40e3, residual = 2e3, softening_slip = 0.1, G = 3e6;  // [Pa], [Pa], [m]

/// A layer of 0.4 m between two rough plates of which the upper one moves.
Json sheared_layer(double length, double h, double speed) {
  const auto number = [h](double size) { return static_cast<int>(std::lround(size / h)); };
  const double height = 0.4, room = 0.6;
  Json clay = elastic_soil("tresca", 2 * G * 1.45, 0.45, 2000);
  clay["cohesion"] = peak;
  clay["softening"] = {{"slip", softening_slip}, {"residual_cohesion", residual}};
  Json top = wall("top", "fixed");
  top["motion"] = {{"velocity", {speed, 0}}};
  return {{"dimension", 2},
          {"analysis", "quasi_static"},
          {"basis", "linear"},
          {"grid", box({0, 0}, {length + 2 * room, height},
                       {number(length + 2 * room), number(height)}, "quad4")},
          {"walls", {wall("bottom", "fixed"), top}},
          {"bodies",
           {body("soil",
                 box({room, 0}, {room + length, height}, {number(length), number(height)}, "quad4"),
                 4, clay)}}};
}

/// Work of the plate until it has slipped by 0.5 m [J/m].
double work_of_slip(double length, double h) {
  const double end = 0.5 + 0.4 * residual / G, dt = 2e-3;
  const int steps = static_cast<int>(std::lround(1 / dt));
  const auto solver = make_mpm(sheared_layer(length, h, end));
  double work = 0, before = 0;
  for (int n = 1; n <= steps; ++n) {
    run_steps(*solver, dt, 1, n);
    const double force = std::abs(probe(*solver, "wall.top.fx"));
    work += 0.5 * (before + force) * end * dt;
    before = force;
  }
  return work;
}

/// The work of a slip surface by its area is c_r d + (c_p - c_r) d_c (1 - exp(-d / d_c)), 4.774396
/// kJ/m^2, whatever the cells. Two lengths of the layer leave out its ends.
TEST(VA2_SlipSurface, does_the_same_work_in_all_cells) {
  const double d = 0.5;
  const double exact =
      residual * d + (peak - residual) * softening_slip * (1 - std::exp(-d / softening_slip));
  for (const double h : {0.2, 0.1, 0.05}) {
    verify({.id = "VA2",
            .what = fmt::format("work of a slip of 0.5 m by its area, Tresca that softens, linear, "
                                "cells of {} m, layers of 4 and 2 m",
                                h),
            .exact = exact,
            .computed = (work_of_slip(4, h) - work_of_slip(2, h)) / 2,
            .bound = 0.03,
            .unit = "J/m^2"});
  }
}

}  // namespace
}  // namespace gabion::test
