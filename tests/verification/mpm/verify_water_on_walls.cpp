// SPDX-License-Identifier: BSD-3-Clause
// Water that strikes, fills up or leans on rigid walls.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {
namespace {

constexpr double g = 9.81, rho = 1000;

/// A box of fluid in a grid of square cells, at x = 0 on its left.
struct Fluid {
  double length, depth, cell;
  double sound_speed, viscosity = 0;
  double speed = 0;       ///< along x at the start [m/s]
  double room_x, room_y;  ///< size of the grid [m]
  std::string bottom = "slip";
  bool weight = true;
};

Json scene(const Fluid& fluid) {
  const auto rows = [&](double size) { return static_cast<int>(std::lround(size / fluid.cell)); };
  Json water = body(
      "water",
      box({0, 0}, {fluid.length, fluid.depth}, {rows(fluid.length), rows(fluid.depth)}, "quad4"), 4,
      {{"law", "newtonian"},
       {"density", rho},
       {"sound_speed", fluid.sound_speed},
       {"viscosity", fluid.viscosity}},
      {fluid.speed, 0});
  if (fluid.weight) {
    water["initial_stress"] = {{"k0", 1}, {"surface", fluid.depth}, {"max_displacement", 1e9}};
  }
  return {{"dimension", 2},
          {"grid", box({0, 0}, {fluid.room_x, fluid.room_y},
                       {rows(fluid.room_x), rows(fluid.room_y)}, "quad4")},
          {"walls", {wall("bottom", fluid.bottom)}},
          {"gravity", {0, fluid.weight ? -g : 0}},
          {"time_integration", {{"scheme", "explicit"}}},
          {"step_control", {{"strain", nullptr}}},
          {"outside", "remove"},
          {"bodies", {water}}};
}

/// A smooth rigid wall at x on the right of the fluid, and its mean force in a span of time.
void add_wall(Json& json, double x, double height, double spacing) {
  json["rigid_walls"] = {{{"name", "wall"},
                          {"surface", {{"polyline", {{x, height}, {x, 0}}}, {"spacing", spacing}}},
                          {"moment_about", {x, 0}},
                          {"friction", 0}}};
}

struct Thrust {
  double force = 0, moment = 0;
};

Thrust mean_thrust(Solver& solver, double dt, double from, double to) {
  const int first = static_cast<int>(std::lround(from / dt)),
            last = static_cast<int>(std::lround(to / dt));
  run_steps(solver, dt, first);
  Thrust mean;
  for (int n = first + 1; n <= last; ++n) {
    run_steps(solver, dt, 1, n);
    mean.force += probe(solver, "wall.fx") / (last - first);
    mean.moment += std::abs(probe(solver, "wall.mz")) / (last - first);
  }
  return mean;
}

TEST(VW25_WaterOnWalls, water_at_rest) {
  for (const double offset : {0.0, 1.0 / 3, 0.5}) {
    const double H = 1, h = 0.1, x = 0.5;
    // The left wall stays on the grid; the one on the right is put into its cell.
    const double cell = x / (5 + offset), depth = cell * std::lround(H / cell);
    Json json = scene({.length = x,
                       .depth = depth,
                       .cell = cell,
                       .sound_speed = 20 * std::sqrt(g * H),
                       .room_x = 8 * cell,
                       .room_y = depth + 2 * cell});
    json["bodies"][0]["mesh"] =
        box({0, 0}, {x, depth}, {10, static_cast<int>(std::lround(2 * depth / h))}, "quad4");
    json["bodies"][0]["points_per_cell"] = 4;
    json["walls"].push_back(wall("left", "slip"));
    add_wall(json, x, depth + cell, h / 2);
    json["time_integration"] = {{"scheme", "bossak"}};
    json.erase("step_control");
    const auto solver = make_mpm(json);
    const Thrust thrust = mean_thrust(*solver, 0.01, 0.2, 0.4);
    const std::string what = fmt::format("N12, water at rest, wall at {:.2f} of a cell: ", offset);
    verify({.id = "VW25",
            .what = what + "force on the wall",
            .exact = rho * g * depth * depth / 2,
            .computed = thrust.force,
            .bound = 0.01,
            .unit = "N/m"});
    verify({.id = "VW25",
            .what = what + "moment about its foot",
            .exact = rho * g * std::pow(depth, 3) / 6,
            .computed = thrust.moment,
            .bound = 0.01,
            .unit = "N"});
  }
}

/// Half of a jet, cut along its axis: all of its momentum goes, as it leaves along the wall.
TEST(VW25_WaterOnWalls, jet_on_a_wall) {
  constexpr double U = 2, half = 0.05, cell = half / 4, length = 1.2;
  Json json = scene({.length = length,
                     .depth = half,
                     .cell = cell,
                     .sound_speed = 10 * U,
                     .speed = U,
                     .room_x = length + 4 * cell,
                     .room_y = 1.2,
                     .weight = false});
  add_wall(json, length, 1.1, cell);
  const auto solver = make_mpm(json);
  const Thrust thrust = mean_thrust(*solver, 1e-3, 0.25, 0.5);
  verify({.id = "VW25",
          .what = "K4, jet of 8 cells on a wall: mean force over rho U^2 h",
          .exact = 1,
          .computed = thrust.force / (rho * U * U * half),
          .bound = 0.03});
}

/// A layer of h_1 that comes with u_1 on a smooth bed is held up by a wall and fills up to h_2:
/// Fr^2 = (r - 1)^2 (r + 1) / (2 r), r = h_2 / h_1, force rho g h_2^2 / 2. What splashes up at
/// first has fallen back after 0.7 s.
TEST(VW25_WaterOnWalls, bore) {
  constexpr double Fr = 1.5, r = 2.822876, h_1 = 0.1, cell = h_1 / 5, length = 4;
  const double u_1 = Fr * std::sqrt(g * h_1);
  Json json = scene({.length = length,
                     .depth = h_1,
                     .cell = cell,
                     .sound_speed = 20 * u_1,
                     .speed = u_1,
                     .room_x = length + 4 * cell,
                     .room_y = 1.2});
  json["walls"].push_back(wall("left", "slip"));
  add_wall(json, length, 1.2, cell);
  const auto solver = make_mpm(json);
  const Thrust thrust = mean_thrust(*solver, 1e-3, 0.8, 1.2);
  verify({.id = "VW25",
          .what = "K2, bore of Froude 1.5 at a wall, 5 cells: mean force over rho g h_2^2 / 2",
          .exact = 1,
          .computed = thrust.force / (0.5 * rho * g * r * r * h_1 * h_1),
          .bound = 0.05});
}

double front(const mpm::MpmSolver<2>& solver) {
  double x = 0;
  for (const auto& place : solver.points().x) x = std::max(x, place[0]);
  return x;
}

/// Column of 2 H x H that breaks: front in t* = t sqrt(g / H), (x - W) / H, of weakly compressible
/// SPH with H / 400 (TrixiParticles).
TEST(VW26_DamBreak, front_of_a_column) {
  constexpr double H = 0.6, W = 2 * H, cell = H / 20, dt = 1e-3;
  Json json = scene({.length = W,
                     .depth = H,
                     .cell = cell,
                     .sound_speed = 20 * std::sqrt(g * H),
                     .room_x = 110 * cell,
                     .room_y = 24 * cell});
  json["walls"].push_back(wall("left", "slip"));
  json["walls"].push_back(wall("right", "slip"));
  const auto solver = mpm_solver<2>(json);
  int done = 0;
  for (const auto& [t, place] :
       {std::pair{1.0, 0.947}, {1.5, 1.756}, {2.0, 2.665}, {2.25, 3.145}}) {
    const int end = static_cast<int>(std::lround(t / std::sqrt(g / H) / dt));
    run_steps(*solver, dt, end - done, done + 1);
    done = end;
    verify({.id = "VW26",
            .what = fmt::format("N10, column of 20 cells, t* = {}: front over the height", t),
            .exact = place,
            .computed = (front(*solver) - W) / H,
            .bound = 0.05});
  }
}

/// Fluid between plates, one of which begins to move: at T = nu t / h^2 its speed is
///
///     u / U = y / h + sum_n 2 (-1)^n / (n pi) sin(n pi y / h) exp(-n^2 pi^2 T)
///
/// The ends are free and far off. Points beside the plate keep some of the jump at the start.
TEST(VW28_Couette, fluid_that_a_plate_takes_along) {
  constexpr double h = 0.1, U = 0.01, nu = 1e-3, dt = 0.01, length = 0.6;
  Json json = scene({.length = length,
                     .depth = h,
                     .cell = h / 10,
                     .sound_speed = 1,
                     .viscosity = nu * rho,
                     .room_x = length + 0.2,
                     .room_y = h,
                     .bottom = "fixed",
                     .weight = false});
  json["bodies"][0]["mesh"] = box({0.1, 0}, {0.1 + length, h}, {60, 10}, "quad4");
  json["bodies"][0]["material"]["cavitation_pressure"] = 1e6;
  json["time_integration"] = {{"scheme", "bossak"}};
  json.erase("step_control");
  json["walls"].push_back(wall("top", "fixed"));
  json["walls"][1]["motion"] = {{"table", {{0, 0, 0}, {10, 10 * U, 0}}}};
  const auto solver = mpm_solver<2>(json);
  int done = 0;
  for (const double T : {0.1, 0.2}) {
    const int end = static_cast<int>(std::lround(T * h * h / nu / dt));
    run_steps(*solver, dt, end - done, done + 1);
    done = end;
    double error = 0;
    for (const double at : {0.25, 0.5, 0.75}) {
      double off = 0;
      int count = 0;
      for (std::int32_t p = 0; p < solver->points().size(); ++p) {
        const Vector<2>& x = solver->points().x[p];
        if (std::abs(x[0] - 0.1 - length / 2) > 0.5 * h || std::abs(x[1] - at * h) > h / 20)
          continue;
        double exact = x[1] / h;
        for (int n = 1; n < 50; ++n) {
          const double k = n * std::numbers::pi;
          exact += 2 * (n % 2 == 0 ? 1 : -1) / k * std::sin(k * x[1] / h) * std::exp(-k * k * T);
        }
        off += solver->points().v[p][0] / U - exact;
        ++count;
      }
      error = std::max(error, std::abs(off / count));
    }
    verify(
        {.id = "VW28",
         .what = fmt::format("N1, Couette, 10 cells, T = {}: largest error of the speed at y / h = "
                             "0.25, 0.5, 0.75 over that of the plate",
                             T),
         .exact = 0,
         .computed = error,
         .measure = Measure::absolute_error,
         .bound = 0.01});
  }
}

}  // namespace
}  // namespace gabion::test
