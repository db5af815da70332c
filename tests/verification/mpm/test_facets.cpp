// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {
namespace {

/// V8: a bar (E, density, L; nu = 0, smooth walls on its sides) that flies against a rigid wall:
/// sigma = rho c v0, time of contact 2 L / c, rebound with -v0.
constexpr double E = 1e6, density = 1e3, L = 1, v0 = 0.1;
const double c = std::sqrt(E / density), contact_time = 2 * L / c;

Json flying_bar(int cells, double penalty_factor) {
  const double h = L / cells;
  return {{"dimension", 2},
          {"grid", box({-2 * h, 0}, {L + 6 * h, h}, {cells + 8, 1}, "quad4")},
          {"basis", "linear"},
          {"walls", {wall("bottom", "slip"), wall("top", "slip")}},
          {"bodies",
           {body("bar", box({0.3 * h, 0}, {L + 0.3 * h, h}, {cells, 1}, "quad4"), 4,
                 elastic_soil("linear_elastic", E, 0, density), {-v0, 0})}},
          {"time_integration", trapezoid},
          {"newton", exact_newton},
          {"rigid_walls",
           {{{"name", "wall"},
             {"method", "facets"},
             {"surface", {{"polyline", {{0, 0}, {0, h}}}, {"spacing", h}}},
             {"mode", "slip"},
             {"penalty_factor", penalty_factor}}}}};
}

double energy(const Solver& solver) {
  return probe(solver, "kinetic_energy") + probe(solver, "elastic_energy") +
         probe(solver, "contact_energy");
}

/// Contact cannot make energy, over four decades of the step size and of the penalty.
TEST(Facets, a_bar_that_hits_a_wall_gains_no_energy) {
  constexpr int cells = 10;
  const double h = L / cells;
  double gained = 0;
  for (const double courant : {0.05, 0.5, 5.0, 50.0}) {
    for (const double factor : {1.0, 100.0, 10000.0}) {
      const auto solver = make_mpm(flying_bar(cells, factor));
      const double dt = courant * h / c, start = energy(*solver);
      const int steps = static_cast<int>(std::ceil((1.3 * contact_time + 0.3 * h / v0) / dt));
      double largest = 0;
      for (int n = 1; n <= steps; ++n) {
        run_steps(*solver, dt, 1, n);
        largest = std::max(largest, energy(*solver));
      }
      const std::string what = fmt::format("Courant number {}, penalty_factor {}", courant, factor);
      gained = std::max(gained, largest / start - 1);
      EXPECT_LT(probe(*solver, "contact_created"), 1e-10 * start) << what;
      EXPECT_LT(std::abs(probe(*solver, "energy_balance")), 1e-9 * start) << what;
      EXPECT_LT(std::abs(probe(*solver, "momentum_error_x")), 1e-9 * density * L * h * v0) << what;
      EXPECT_GT(probe(*solver, "momentum_x"), 0) << what;  // it came back
    }
  }
  verify({.id = "V8",
          .what =
              "bar on a rigid wall by facets, Courant number 0.05 to 50, penalty_factor 1 to 1e4: "
              "energy gained over that at the start",
          .exact = 0,
          .computed = gained,
          .measure = Measure::absolute_error,
          .bound = 1e-7});  // Newton leaves 1e-10 a step
}

TEST(Facets, a_bar_that_hits_a_wall) {
  constexpr int cells = 40;
  const double h = L / cells, dt = contact_time / 400;
  const auto solver = make_mpm(flying_bar(cells, 20));
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
  verify({.id = "V8",
          .what = "bar on a rigid wall by facets, contact stress, 2D, 40 cells",
          .exact = density * c * v0,
          .computed = plateau / time_on_plateau / h,
          .bound = 0.01,
          .unit = "Pa"});
  verify({.id = "V8",
          .what = "bar on a rigid wall by facets, impulse over force, a time, 2D, 40 cells",
          .exact = contact_time,
          .computed = impulse / h / (density * c * v0),
          .bound = 0.03,
          .unit = "s",
          .limitation =
              "linear cells disperse the wave front: part of the energy stays in vibration"});
}

/// V9: an elastic block on an incline of 30 degrees, placed `above` it; gravity is turned instead.
struct Slide {
  double speed = 0, lowest = 0;
  double pitch = 0;           // mean over time [rad]
  double largest_pitch = 0;   // [rad]
  double pull = 0, push = 0;  // impulses on the plane, along it and into it
};
Slide slide(double mu, double above, double wall_height) {
  const double angle = M_PI / 6, g = 9.81, low = wall_height + above;
  const auto solver = make_mpm(
      {{"dimension", 2},
       {"grid", box({0, 0}, {2, 1}, {20, 10}, "quad4")},
       {"basis", "linear"},
       {"gravity", {g * std::sin(angle), -g * std::cos(angle)}},
       {"bodies",
        {body("block", box({0.53, low}, {1.03, low + 0.3}, {10, 6}, "quad4"), 4,
              elastic_soil("neo_hookean", 1e7, 0.2, 1000))}},
       {"time_integration", {{"scheme", "bossak"}, {"alpha", -0.3}}},
       {"probes",
        {{{"name", "tail"}, {"point", {0.55, low + 0.02}}},
         {{"name", "nose"}, {"point", {1.01, low + 0.02}}}}},
       {"rigid_walls",
        {{{"name", "incline"},
          {"method", "facets"},
          {"surface", {{"polyline", {{2, wall_height}, {0, wall_height}}}, {"spacing", 0.1}}},
          {"friction", mu}}}}});
  Slide found;
  for (int n = 1; n <= 400; ++n) {
    run_steps(*solver, 5e-4, 1, n);
    const double tail = probe(*solver, "tail.uy"), nose = probe(*solver, "nose.uy");
    found.lowest = std::max(found.lowest, -0.5 * (tail + nose));
    found.pitch += (nose - tail) / 0.46 / 400;
    found.largest_pitch = std::max(found.largest_pitch, std::abs(nose - tail) / 0.46);
    found.pull += 5e-4 * probe(*solver, "incline.fx");
    found.push -= 5e-4 * probe(*solver, "incline.fy");
  }
  found.speed = probe(*solver, "momentum_x") / probe(*solver, "mass");
  return found;
}

TEST(Facets, block_on_an_incline) {
  for (const double wall_height :
       {0.1, 0.15, 0.17}) {  // on a line of the grid, in mid-cell, between
    for (const double mu : {0.0, 0.3}) {
      const Slide found = slide(mu, 0, wall_height);
      verify({.id = "V9",
              .what = fmt::format("block on an incline by facets, wall at {} m, friction over "
                                  "normal impulse",
                                  wall_height),
              .exact = mu,
              .computed = found.pull / found.push,
              .measure = Measure::absolute_error,
              .bound = 1e-4});
      if (mu == 0) {
        verify({.id = "V9",
                .what = fmt::format("block on an incline by facets, mu = 0, wall at {} m, speed "
                                    "after 0.2 s",
                                    wall_height),
                .exact = 9.81 * 0.5 * 0.2,
                .computed = found.speed,
                .bound = 1e-6,
                .unit = "m/s"});
      }
      EXPECT_LT(std::abs(found.pitch), 1e-3) << mu << " " << wall_height;
      EXPECT_LT(found.largest_pitch, 2e-3) << mu << " " << wall_height;
    }
  }
}

/// Soil does not hover: a block comes down by the gap that it was placed with.
TEST(Facets, a_block_above_a_plane_comes_down_to_it) {
  for (const double above : {3e-3, 9e-3}) {
    const double lowest = slide(0.3, above, 0.15).lowest;
    EXPECT_GT(lowest, above) << above;
    verify(
        {.id = "V9",
         .what = fmt::format("block placed {} mm above a plane of facets: falls by", 1e3 * above),
         .exact = above,
         .computed = lowest,
         .measure = Measure::absolute_error,
         .bound = 3e-3,
         .unit = "m"});
  }
}

/// A block of soil that flies at a wall of a fifth of a cell, whose near face is at x.
Json shot_at_wall(const Vector<2>& velocity, double x) {
  const double far = x + 0.02;
  return {
      {"dimension", 2},
      {"grid", box({0, 0}, {4, 2}, {40, 20}, "quad4")},
      {"basis", "linear"},
      {"bodies",
       {body("shot", box({0.4, 0.8}, {0.7, 1.1}, {3, 3}, "quad4"), 4,
             elastic_soil("neo_hookean", 1e7, 0.2, 1000), {velocity[0], velocity[1]})}},
      {"newton", {{"max_iterations", 50}}},
      {"rigid_walls",
       {{{"name", "wall"},
         {"method", "facets"},
         {"surface", {{"polyline", {{far, 0}, {far, 2}, {x, 2}, {x, 0}}}, {"spacing", 0.1}}}}}}};
}

/// Soil that flies at 20 m/s at a wall of a fifth of a cell, half a cell or two in a step.
TEST(Facets, nothing_passes_through_a_thin_wall) {
  for (const double dt : {0.0025, 0.01}) {
    Json json = shot_at_wall({20, 3}, 1.5);
    json["time_integration"] = {{"scheme", "bossak"}, {"alpha", -0.3}};
    json["rigid_walls"][0]["friction"] = 0.3;
    const auto solver = mpm_solver<2>(json);
    run_steps(*solver, dt, static_cast<int>(std::lround(0.06 / dt)));
    double farthest = 0;
    for (const auto& x : solver->points().x) farthest = std::max(farthest, x[0]);
    verify(
        {.id = "V8",
         .what = fmt::format("soil of 20 m/s at a wall of facets a fifth of a cell thick, dt {} s: "
                             "path beyond its face",
                             dt),
         .exact = 0,
         .computed = std::max(0.0, farthest - 1.5),
         .measure = Measure::absolute_error,
         .bound = 1e-12,
         .unit = "m"});
    EXPECT_LT(probe(*solver, "momentum_x"), 0) << dt;  // it was thrown back
  }
}

/// Springs so soft that they stop soil only when the centres of its points are half a cell or more
/// behind the surface, and through the far side of the wall: they throw it back all the same.
TEST(Facets, soil_that_goes_through_a_soft_surface_comes_back) {
  double gained = 0;
  for (const double factor : {0.01, 0.1}) {
    for (const double dt : {0.0005, 0.002}) {
      Json json = shot_at_wall({10, 0}, 0.72);
      json["time_integration"] = trapezoid;
      json["rigid_walls"][0]["mode"] = "slip";
      json["rigid_walls"][0]["penalty_factor"] = factor;
      const auto solver = mpm_solver<2>(json);
      const double start = energy(*solver);
      double front = 0, farthest = 0;
      const auto done = [&] { return probe(*solver, "momentum_x") < 0 && front < 0.72; };
      for (int n = 1; n <= std::lround(0.1 / dt) && !done(); ++n) {
        run_steps(*solver, dt, 1, n);
        front = 0;
        for (const auto& x : solver->points().x) front = std::max(front, x[0]);
        farthest = std::max(farthest, front);
        gained = std::max(gained, energy(*solver) / start - 1);
      }
      EXPECT_GT(farthest, 0.74) << factor << " " << dt;  // behind the far side
      EXPECT_TRUE(done()) << factor << " " << dt << " " << front;
    }
  }
  verify({.id = "V8",
          .what = "soil of 10 m/s through a wall of soft facets and back: energy gained over that "
                  "at the start",
          .exact = 0,
          .computed = gained,
          .measure = Measure::absolute_error,
          .bound = 1e-6});
}

}  // namespace
}  // namespace gabion::test
