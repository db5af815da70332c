// SPDX-License-Identifier: BSD-3-Clause
// Newtonian fluid: at rest, between walls, down a slope, in a tank, over a dry bed.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {
namespace {

constexpr double g = 9.81;

Json fluid(double density, double sound_speed, double viscosity, double cavitation_pressure = 0) {
  return {{"law", "newtonian"},
          {"density", density},
          {"sound_speed", sound_speed},
          {"viscosity", viscosity},
          {"cavitation_pressure", cavitation_pressure}};
}

/// A tank with smooth walls, filled up to `depth` and at rest under its weight.
struct Tank {
  double length = 1, depth = 0.5, cell = 1.0 / 16;
  double viscosity = 0;
  std::string scheme = "bossak";

  int cells(double size) const { return static_cast<int>(std::lround(size / cell)); }
  double sound_speed() const { return 10 * std::sqrt(g * depth); }
};

/// Body cells are half as large as those of the grid, one point in each, so that the surface may
/// lie within a cell.
Json tank_scene(const Tank& tank) {
  const double top = tank.cell * (tank.cells(tank.depth) + 2);
  Json water = body(
      "water",
      box({0, 0}, {tank.length, tank.depth},
          {2 * tank.cells(tank.length), static_cast<int>(std::lround(2 * tank.depth / tank.cell))},
          "quad4"),
      1, fluid(1000, tank.sound_speed(), tank.viscosity));
  water["initial_stress"] = {{"k0", 1}, {"surface", tank.depth}, {"max_displacement", 0.1}};
  Json json = {{"dimension", 2},
               {"grid", box({0, 0}, {tank.length, top}, {tank.cells(tank.length), tank.cells(top)},
                            "quad4")},
               {"walls", {wall("left", "slip"), wall("bottom", "slip"), wall("right", "slip")}},
               {"gravity", {0, -g}},
               {"bodies", {water}},
               {"time_integration", {{"scheme", tank.scheme}}}};
  if (tank.scheme == "explicit") json["step_control"] = {{"strain", nullptr}};
  return json;
}

/// Largest displacement of a point in 0.4 s, over the size of a cell.
double largest_way(const Tank& tank) {
  const auto solver = mpm_solver<2>(tank_scene(tank));
  const auto start = solver->points().x;
  run_steps(*solver, 2e-3, 200);
  double path = 0;
  for (std::size_t p = 0; p < start.size(); ++p) {
    path = std::max(path, (solver->points().x[p] - start[p]).norm());
  }
  return path / tank.cell;
}

TEST(Fluid, stays_at_rest_under_its_weight) {
  for (const std::string scheme : {"bossak", "explicit"}) {
    for (const double depth : {0.5, 0.5 + 1.0 / 32}) {
      verify({.id = "fluid",
              .what = fmt::format(
                  "P9, water alone, at rest in a tank, {} steps, surface {} a cell: largest "
                  "displacement of a point in 0.4 s over the size of a cell",
                  scheme, depth == 0.5 ? "at the edge of" : "in the middle of"),
              .exact = 0,
              .computed = largest_way({.length = 0.5, .depth = depth, .scheme = scheme}),
              .measure = Measure::absolute_error,
              .bound = 1e-5});
    }
  }
}

/// Standing wave of small height: omega^2 = g k tanh(k H), with velocities
///
///     u = a sin(k x) cosh(k y) / cosh(k H) ,  v = -a cos(k x) sinh(k y) / cosh(k H)
///
/// at the instant at which the surface is level. The momentum along the tank goes with
/// cos(omega t).
/// @returns time from its first to its third change of sign, a period [s]
double sloshing_period(const Tank& tank) {
  constexpr double a = 0.02, dt = 2e-3;
  const double k = std::numbers::pi / tank.length;
  const auto solver = mpm_solver<2>(tank_scene(tank));
  std::vector<Vector<2>> v;
  for (const Vector<2>& x : solver->points().x) {
    const double size = a / std::cosh(k * tank.depth);
    v.emplace_back(size * std::sin(k * x[0]) * std::cosh(k * x[1]),
                   -size * std::cos(k * x[0]) * std::sinh(k * x[1]));
  }
  const std::vector<Vector<2>> at_rest(v.size(), Vector<2>::Zero());
  solver->set_motion(std::move(v), at_rest);
  std::vector<double> crossings;
  double before = 1;
  for (int n = 1; crossings.size() < 3; ++n) {
    run_steps(*solver, dt, 1, n);
    const double now = probe(*solver, "momentum_x");
    if ((now > 0) != (before > 0)) crossings.push_back(dt * (n - now / (now - before)));
    before = now;
    if (n > 2000) throw Error("the wave does not swing");
  }
  return crossings[2] - crossings[0];
}

TEST(Fluid, sloshes_with_the_period_of_gravity_waves) {
  for (const auto& [scheme, cells, bound] :
       {std::tuple{"bossak", 16, 0.015}, {"explicit", 32, 0.01}}) {
    const Tank tank{.cell = 1.0 / cells, .scheme = scheme};
    const double k = std::numbers::pi / tank.length;
    verify({.id = "fluid",
            .what = fmt::format("N11, wave in a tank, {} x {} cells, {} steps: period", cells,
                                cells / 2, scheme),
            .exact = 2 * std::numbers::pi / std::sqrt(g * k * std::tanh(k * tank.depth)),
            .computed = sloshing_period(tank),
            .bound = bound,
            .unit = "s"});
  }
}

/// A column that begins to fall between two walls to which it sticks: of the mean speed g H^2 / (3
/// nu) there is, at T = nu t / H^2,
///
///     1 - sum_i 6 / l_i^4 exp(-l_i^2 T) ,  l_i = (2 i + 1) pi / 2
struct FallingColumn {
  double half = 0.05, density = 1500, viscosity = 0;
  std::string scheme;

  double speed(double time) const {
    const double nu = viscosity / density;
    double missing = 0;
    for (int i = 0; i < 20; ++i) {
      const double l = (2 * i + 1) * std::numbers::pi / 2;
      missing += 6 / std::pow(l, 4) * std::exp(-l * l * nu * time / (half * half));
    }
    return g * half * half / (3 * nu) * (1 - missing);
  }
  /// @param length  of the column [m]
  double computed(double time, double length) const {
    constexpr double h = 0.01, above = 0.1, dt = 1e-3;
    const auto rows = [](double height) { return static_cast<int>(std::lround(height / h)); };
    Json json = {
        {"dimension", 2},
        {"grid", box({0, 0}, {2 * half, length + 2 * above},
                     {rows(2 * half), rows(length + 2 * above)}, "quad4")},
        {"walls", {wall("left", "fixed"), wall("right", "fixed")}},
        {"gravity", {0, -g}},
        {"time_integration", {{"scheme", scheme}}},
        {"bodies",
         {body("oil",
               box({0, above}, {2 * half, above + length}, {rows(2 * half), rows(length)}, "quad4"),
               4, fluid(density, 10, viscosity, 1e6))}}};
    if (scheme == "explicit") json["step_control"] = {{"strain", nullptr}};
    const auto solver = make_mpm(json);
    run_steps(*solver, dt, static_cast<int>(std::lround(time / dt)));
    return -probe(*solver, "momentum_y") / probe(*solver, "mass");
  }
};

/// The ends of the column, which no fluid holds from beyond, count as the inverse of its length.
/// The thickest fluid takes explicit steps that viscosity limits: 0.2 of those of sound.
TEST(Fluid, falls_between_walls_with_the_speed_of_its_viscosity) {
  for (const auto& [scheme, viscosity, time] : {std::tuple{"bossak", 50.0, 0.05},
                                                {"bossak", 50.0, 0.2},
                                                {"explicit", 50.0, 0.05},
                                                {"explicit", 300.0, 0.05}}) {
    const FallingColumn column{.viscosity = viscosity, .scheme = scheme};
    verify({.id = "fluid",
            .what = fmt::format(
                "N2, Poiseuille, column between rough walls, {} Pa s, {} steps, 10 cells: mean "
                "speed after {} s, extrapolated in the length of the column",
                viscosity, scheme, time),
            .exact = column.speed(time),
            .computed = 2 * column.computed(time, 0.8) - column.computed(time, 0.4),
            .bound = 0.02,
            .unit = "m/s"});
  }
}

/// Film that starts down a rough slope, of u_ref = g sin(theta) h^2 / (2 nu) at T = nu t / h^2 =
/// 0.1 the shares 0.197746 at the surface and 0.176878 in the middle (series as above). The ends
/// are smooth walls too far off to be felt.
TEST(Fluid, film_starts_down_a_slope) {
  constexpr double depth = 0.1, slope = 10 * std::numbers::pi / 180, density = 1500, mu = 5;
  constexpr double u_ref = g * 0.17364817766693033 * depth * depth / (2 * mu / density);
  constexpr double length = 1.6, h = depth / 15, time = 0.3, dt = 2e-3;
  Json layer =
      body("film", box({0, 0}, {length, depth}, {240, 15}, "quad4"), 4, fluid(density, 15, mu));
  layer["initial_stress"] = {{"k0", 1}, {"surface", depth}, {"max_displacement", 0.1}};
  auto settings = mpm_settings<2>(
      {{"dimension", 2},
       {"grid", box({0, 0}, {length, 2 * depth}, {240, 30}, "quad4")},
       {"walls", {wall("bottom", "fixed"), wall("left", "slip"), wall("right", "slip")}},
       {"gravity", {0, -g * std::cos(slope)}},
       {"time_integration", {{"scheme", "explicit"}}},
       {"step_control", {{"strain", nullptr}}},
       {"bodies", {layer}}});
  settings.body_acceleration = [slope](const Vector<2>&, double) -> Vector<2> {
    return g * std::sin(slope) * Vector<2>::Unit(0);
  };
  mpm::MpmSolver<2> solver(comm(), std::move(settings), "");
  run_steps(solver, dt, static_cast<int>(std::lround(time / dt)));
  const auto mean_speed = [&](double low, double high) {
    double sum = 0, count = 0;
    for (std::size_t p = 0; p < solver.points().x.size(); ++p) {
      const Vector<2>& x = solver.points().x[p];
      if (std::abs(x[0] - length / 2) > 0.1 || x[1] < low || x[1] > high) continue;
      sum += solver.points().v[p][0];
      ++count;
    }
    return sum / count;
  };
  verify({.id = "fluid",
          .what = "N2, film down a slope, 15 cells, explicit steps: speed at the surface",
          .exact = 0.197746 * u_ref,
          .computed = mean_speed(depth - h, depth + h),
          .bound = 0.02,
          .unit = "m/s"});
  verify({.id = "fluid",
          .what = "N2, the same in the middle",
          .exact = 0.176878 * u_ref,
          .computed = mean_speed(depth / 2 - h, depth / 2 + h),
          .bound = 0.02,
          .unit = "m/s"});
}

/// A reservoir of depth h is let go on a dry bed: in shallow water what passes the place of the
/// gate is 8/27 h c a second, c = sqrt(g h), the depth stays 4/9 h there, and the front has 2 c
/// (Ritter 1892). Water that is not shallow at the start comes to it as 1 / t.
TEST(Fluid, breaks_out_as_shallow_water) {
  constexpr double h = 0.5, cell = h / 10, length = 12 * h, dry = 22 * h, dt = 2e-3;
  const double c = std::sqrt(g * h), time = 10 * h / c;
  const auto rows = [](double size) { return static_cast<int>(std::lround(size / cell)); };
  Json water = body("water", box({0, 0}, {length, h}, {rows(length), rows(h)}, "quad4"), 4,
                    fluid(1000, 10 * c, 0));
  water["initial_stress"] = {{"k0", 1}, {"surface", h}, {"max_displacement", 1e9}};
  const auto solver = mpm_solver<2>(
      {{"dimension", 2},
       {"grid", box({0, 0}, {length + dry, 1.4 * h}, {rows(length + dry), rows(1.4 * h)}, "quad4")},
       {"walls", {wall("left", "slip"), wall("bottom", "slip"), wall("right", "slip")}},
       {"gravity", {0, -g}},
       {"time_integration", {{"scheme", "explicit"}}},
       {"step_control", {{"strain", nullptr}}},
       {"bodies", {water}}});
  const int steps = static_cast<int>(std::lround(time / dt));
  run_steps(*solver, dt, steps);
  const auto& points = solver->points();
  const double path = c * steps * dt, around = 0.15 * path;
  double passed = 0, at_gate = 0, front = 0;
  for (std::size_t p = 0; p < points.x.size(); ++p) {
    const double x = points.x[p][0] - length, volume = points.V0[p] * points.J[p];
    if (x > 0) passed += volume;
    if (std::abs(x) < around) at_gate += volume / (2 * around);
    front = std::max(front, x);
  }
  const std::string what = "dam break on a dry bed, 10 cells, after 10 sqrt(h / g): ";
  const std::string limitation = "water that is not shallow at the start";
  verify({.id = "fluid",
          .what = "N9, " + what + "volume past the gate",
          .exact = 8. / 27 * h * path,
          .computed = passed,
          .bound = 0.03,
          .unit = "m^2",
          .limitation = limitation});
  verify({.id = "fluid",
          .what = "N9, " + what + "depth at the gate",
          .exact = 4. / 9 * h,
          .computed = at_gate,
          .bound = 0.03,
          .unit = "m",
          .limitation = limitation});
  verify({.id = "fluid",
          .what = "N9, " + what + "front",
          .exact = 2 * path,
          .computed = front,
          .bound = 0.1,
          .unit = "m",
          .limitation = limitation});
}

}  // namespace
}  // namespace gabion::test
