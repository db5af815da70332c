// SPDX-License-Identifier: BSD-3-Clause
// Explicit steps and rigid walls of facets.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {
namespace {

/// V8: a bar (nu = 0, smooth walls on its sides) that flies against a rigid wall: sigma = rho c v0,
/// time of contact 2 L / c, rebound with -v0.
constexpr double E = 1e6, density = 1e3, L = 1, v0 = 0.1;
const double c = std::sqrt(E / density), contact_time = 2 * L / c;

template <int dim>
Json flying_bar(int cells, double courant, double penalty_factor) {
  const double h = L / cells;
  std::vector<double> low(dim, 0.0), high(dim, h), from(dim, 0.0), to(dim, h), v(dim, 0.0);
  std::vector<int> count(dim, 1), body_count(dim, 1);
  low[0] = -2 * h;
  high[0] = L + 6 * h;
  count[0] = cells + 8;
  from[0] = 0.3 * h;
  to[0] = L + 0.3 * h;
  body_count[0] = cells;
  v[0] = -v0;
  const std::string type = dim == 2 ? "quad4" : "hex8";
  Json walls = {wall("bottom", "slip"), wall("top", "slip")};
  Json surface;
  if (dim == 2) {
    surface = {{"polyline", {{0, 0}, {0, h}}}, {"spacing", h}};
  } else {
    walls.push_back(wall("front", "slip"));
    walls.push_back(wall("back", "slip"));
    surface = {{"mesh", box({-h, 0, 0}, {0, h, h}, {1, 1, 1}, "hex8")}, {"groups", {"right"}}};
  }
  return {{"dimension", dim},
          {"grid", box(low, high, count, type)},
          {"basis", "linear"},
          {"walls", walls},
          {"bodies",
           {body("bar", box(from, to, body_count, type), dim == 2 ? 4 : 8,
                 elastic_soil("linear_elastic", E, 0, density), v)}},
          {"time_integration", {{"scheme", "explicit"}, {"courant", courant}}},
          {"rigid_walls",
           {{{"name", "wall"},
             {"method", "facets"},
             {"surface", surface},
             {"mode", "slip"},
             {"penalty_factor", penalty_factor}}}}};
}

double energy(const Solver& solver) {
  return probe(solver, "kinetic_energy") + probe(solver, "elastic_energy") +
         probe(solver, "contact_energy");
}

/// Whatever the substep and the penalty: a stiffer contact asks for shorter substeps by itself.
TEST(ExplicitContact, a_bar_that_hits_a_wall_gains_no_energy) {
  constexpr int cells = 10;
  const double h = L / cells;
  double gained = 0;
  for (const double courant : {0.1, 0.5, 0.9}) {
    for (const double factor : {1.0, 100.0, 10000.0}) {
      const auto solver = make_mpm(flying_bar<2>(cells, courant, factor));
      const double dt = h / c, start = energy(*solver);
      const int steps = static_cast<int>(std::ceil((1.3 * contact_time + 0.3 * h / v0) / dt));
      double largest = 0;
      for (int n = 1; n <= steps; ++n) {
        run_steps(*solver, dt, 1, n);
        largest = std::max(largest, energy(*solver));
      }
      const std::string what = fmt::format("courant {}, penalty_factor {}", courant, factor);
      gained = std::max(gained, largest / start - 1);
      EXPECT_LT(std::abs(probe(*solver, "energy_balance")), 1e-9 * start) << what;
      EXPECT_LT(std::abs(probe(*solver, "momentum_error_x")), 1e-12 * density * L * h * v0) << what;
      EXPECT_GT(probe(*solver, "momentum_x"), 0) << what;  // it came back
    }
  }
  verify({.id = "V8",
          .what =
              "bar on a rigid wall by facets, explicit, courant 0.1 to 0.9, penalty_factor 1 to "
              "1e4: energy gained over that at the start",
          .exact = 0,
          .computed = gained,
          .measure = Measure::absolute_error,
          .bound = 1e-3});
}

template <int dim>
void check_bar(int cells) {
  const double h = L / cells, dt = contact_time / 400, side = std::pow(h, dim - 1);
  const auto solver = make_mpm(flying_bar<dim>(cells, 0.9, 20));
  const double arrival = 0.3 * h / v0;
  double impulse = 0, plateau = 0, time_on_plateau = 0;
  for (int n = 1; n * dt < arrival + 1.3 * contact_time; ++n) {
    run_steps(*solver, dt, 1, n);
    const double force = -probe(*solver, "wall.fx");
    impulse += dt * force;
    const double t = (n * dt - arrival) / contact_time;
    if (t < 0.2 || t > 0.8) continue;
    plateau += dt * force;
    time_on_plateau += dt;
  }
  EXPECT_EQ(probe(*solver, "wall.fx"), 0);  // it left
  EXPECT_LT(probe(*solver, "momentum_x"), density * L * side * v0);
  verify({.id = "V8",
          .what = fmt::format("bar on a rigid wall by facets, explicit, contact stress, {}D, {} "
                              "cells",
                              dim, cells),
          .exact = density * c * v0,
          .computed = plateau / time_on_plateau / side,
          .bound = 0.015,
          .unit = "Pa"});
  verify({.id = "V8",
          .what = fmt::format("bar on a rigid wall by facets, explicit, impulse over force, a "
                              "time, {}D, {} cells",
                              dim, cells),
          .exact = contact_time,
          .computed = impulse / side / (density * c * v0),
          .bound = 0.03,
          .unit = "s",
          .limitation =
              "linear cells disperse the wave front: part of the energy stays in vibration"});
}
TEST(ExplicitContact, a_bar_that_hits_a_wall) {
  check_bar<2>(40);
  check_bar<3>(40);
}

/// V9: an elastic block on an incline of 30 degrees; gravity is turned instead.
TEST(ExplicitContact, block_on_an_incline) {
  const double angle = M_PI / 6, g = 9.81;
  for (const double mu : {0.0, 0.3}) {
    for (const std::string basis : {"linear", "gimp"}) {
      const auto solver =
          make_mpm({{"dimension", 2},
                    {"grid", box({0, 0}, {2, 1}, {20, 10}, "quad4")},
                    {"basis", basis},
                    {"gravity", {g * std::sin(angle), -g * std::cos(angle)}},
                    {"bodies",
                     {body("block", box({0.53, 0.17}, {1.03, 0.47}, {10, 6}, "quad4"), 4,
                           elastic_soil("neo_hookean", 1e7, 0.2, 1000))}},
                    {"time_integration", {{"scheme", "explicit"}}},
                    {"rigid_walls",
                     {{{"name", "incline"},
                       {"surface", {{"polyline", {{2, 0.17}, {0, 0.17}}}, {"spacing", 0.1}}},
                       {"friction", mu}}}}});
      double pull = 0, push = 0;
      for (int n = 1; n <= 100; ++n) {
        run_steps(*solver, 2e-3, 1, n);
        pull += 2e-3 * probe(*solver, "incline.fx");
        push -= 2e-3 * probe(*solver, "incline.fy");
      }
      verify({.id = "V9",
              .what = fmt::format("block on an incline by facets, explicit, {}, friction over "
                                  "normal impulse",
                                  basis),
              .exact = mu,
              .computed = pull / push,
              .measure = Measure::absolute_error,
              .bound = 1e-4});
      verify({.id = "V9",
              .what = fmt::format("block on an incline by facets, explicit, {}, mu = {}, speed "
                                  "after 0.2 s",
                                  basis, mu),
              .exact = g * (std::sin(angle) * 0.2 - mu * push / (1000 * 0.15) / g),
              .computed = probe(*solver, "momentum_x") / probe(*solver, "mass"),
              .bound = 1e-3,
              .unit = "m/s"});
    }
  }
}

/// Soil that flies at 20 m/s at a wall of a fifth of a cell, half a cell or two in a step.
TEST(ExplicitContact, nothing_passes_through_a_thin_wall) {
  for (const double dt : {0.0025, 0.01}) {
    const auto solver = mpm_solver<2>(
        {{"dimension", 2},
         {"grid", box({0, 0}, {4, 2}, {40, 20}, "quad4")},
         {"bodies",
          {body("shot", box({0.4, 0.8}, {0.7, 1.1}, {3, 3}, "quad4"), 4,
                elastic_soil("neo_hookean", 1e7, 0.2, 1000), {20, 3})}},
         {"time_integration", {{"scheme", "explicit"}}},
         {"rigid_walls",
          {{{"name", "wall"},
            {"friction", 0.3},
            {"surface",
             {{"polyline", {{1.52, 0}, {1.52, 2}, {1.5, 2}, {1.5, 0}}}, {"spacing", 0.1}}}}}}});
    run_steps(*solver, dt, static_cast<int>(std::lround(0.06 / dt)));
    double farthest = 0;
    for (const auto& x : solver->points().x) farthest = std::max(farthest, x[0]);
    verify({.id = "V8",
            .what = fmt::format("explicit, soil of 20 m/s at a wall of a fifth of a cell, steps of "
                                "{:g} s: path beyond its face",
                                dt),
            .exact = 0,
            .computed = std::max(0.0, farthest - 1.5),
            .measure = Measure::absolute_error,
            .bound = 0,
            .unit = "m"});
    EXPECT_LT(probe(*solver, "momentum_x"), 0) << dt;  // it was thrown back
  }
}

}  // namespace
}  // namespace gabion::test
