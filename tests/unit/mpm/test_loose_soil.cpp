// SPDX-License-Identifier: BSD-3-Clause
// Soil without cohesion whose points come loose and are caught again within a solution.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test::test_loose_soil {
namespace {

Json sand(double friction_angle, double young_modulus, double density) {
  Json material = elastic_soil("mohr_coulomb", young_modulus, 0.3, density);
  material["friction_angle"] = friction_angle;
  material["dilation_angle"] = 0;
  material["cohesion"] = 0;
  return material;
}

/// Grains of one point each that slide over a bed, a share of a cell above a row of nodes that
/// falls from 1e-1 to 1e-6.5: the nodes above them weigh next to nothing.
Json grains_on_a_bed(double gravity, const std::string& apex_volume) {
  const int count = 12;
  const double h = 0.005, length = (2 * count + 2) * h, size = h / 2.2;
  Json material = sand(19.8, 840e3, 2650);
  material["apex_volume"] = apex_volume;
  Json bodies = {
      body("bed", box({0, 0}, {length, 2 * h}, {2 * count + 2, 2}, "tri3"), 3, material)};
  for (int i = 0; i < count; ++i) {
    const double x = h * (2 * i + 1.31 + 0.03 * i), y = 2 * h + h * std::pow(10, -1 - 0.5 * i);
    const Json grain =
        box({x - size / 2, y - size / 2}, {x + size / 2, y + size / 2}, {1, 1}, "quad4");
    bodies.push_back(body("grain_" + std::to_string(i), grain, 1, material,
                          {0.013 * (1 + 0.1 * i), -0.012 * (1 + 0.07 * i)}));
  }
  return {{"dimension", 2},
          {"grid", box({0, 0}, {length, 6 * h}, {2 * count + 2, 6}, "tri3")},
          {"walls", {wall("left", "slip"), wall("bottom", "fixed"), wall("right", "slip")}},
          {"gravity", {0, -gravity}},
          {"locking", {{"method", "none"}}},
          {"newton", {{"residual_tolerance", 1e-7}}},
          {"time_integration", {{"scheme", "bossak"}, {"alpha", -0.3}}},
          {"bodies", bodies}};
}

struct SolvedSteps {
  std::vector<int> iterations;  // of each step
  std::unique_ptr<mpm::MpmSolver<2>> solver;
};

/// Every step has to be solved as it is.
SolvedSteps solve_steps(const Json& json, double dt, int count) {
  SolvedSteps result{{}, mpm_solver<2>(json)};
  for (int n = 1; n <= count; ++n) {
    const StepRequest request{n, 0, (n - 1) * dt, dt};
    InterfaceValues sent;
    result.iterations.push_back(result.solver->solve_step(request, {}, sent).newton_iterations);
    result.solver->accept_step(request, true);
  }
  return result;
}

TEST(LooseSoil, grains_need_no_smaller_step) {
  solve_steps(grains_on_a_bed(9.81, "gap"), 2e-4, 60);
}

TEST(LooseSoil, round_off_in_the_data_decides_nothing) {
  const double dt = 2e-4, h = 0.005;
  const int count = 45;
  const SolvedSteps first = solve_steps(grains_on_a_bed(9.81, "forget"), dt, count);
  for (int k = 1; k <= 10; ++k) {
    const Json json = grains_on_a_bed(9.81 * (1 + k * 1e-14), "forget");
    const SolvedSteps other = solve_steps(json, dt, count);
    for (int n = 0; n < count; ++n) {
      EXPECT_NEAR(other.iterations[n], first.iterations[n], 1) << k << ' ' << n;
    }
    const auto &a = first.solver->points(), &b = other.solver->points();
    for (std::int32_t p = 0; p < a.size(); ++p) {
      EXPECT_LT((a.u[p] - b.u[p]).norm(), 1e-10 * h) << k << ' ' << p;
    }
  }
}

/// A layer on a slope of 20 degrees, in its axes, under gravity that comes gradually.
Json slope(const std::string& basis, const std::string& locking) {
  const double angle = 20 * std::numbers::pi / 180;
  return {
      {"dimension", 2},
      {"analysis", "quasi_static"},
      {"basis", basis},
      {"grid", box({0, 0}, {1, 0.3}, {20, 9}, "quad4")},
      {"walls", {wall("left", "slip"), wall("bottom", "fixed"), wall("right", "slip")}},
      {"gravity", {9.81 * std::sin(angle), -9.81 * std::cos(angle)}},
      {"gravity_ramp", {{"duration", 1}}},
      {"locking", {{"method", locking}}},
      {"bodies", {body("soil", box({0, 0}, {1, 0.2}, {20, 6}, "quad4"), 4, sand(30, 1e6, 1600))}},
      {"newton", {{"residual_tolerance", 1e-7}}}};
}

/// No step of the ramp fails, the walls carry the weight, and no point more than friction allows.
TEST(LooseSoil, takes_its_weight_on_a_slope_from_the_unstressed_state) {
  for (const char* basis : {"linear", "gimp"}) {
    for (const char* locking : {"none", "fbar"}) {
      SCOPED_TRACE(std::string(basis) + ' ' + locking);
      const SolvedSteps result = solve_steps(slope(basis, locking), 0.05, 20);
      const Solver& solver = *result.solver;
      const double weight = probe(solver, "mass") * 9.81, angle = 20 * std::numbers::pi / 180;
      double fx = 0, fy = 0;
      for (const char* name : {"left", "bottom", "right"}) {
        fx += probe(solver, fmt::format("wall.{}.fx", name));
        fy += probe(solver, fmt::format("wall.{}.fy", name));
      }
      EXPECT_NEAR(fx, weight * std::sin(angle), 1e-7 * weight);
      EXPECT_NEAR(fy, -weight * std::cos(angle), 1e-7 * weight);
      const auto& points = result.solver->points();
      for (std::int32_t p = 0; p < points.size(); ++p) {
        const auto& tau = points.tau[p];
        const double mean = (tau[0] + tau[1]) / 2;
        const double radius = std::hypot((tau[0] - tau[1]) / 2, tau[3]);
        EXPECT_LE(radius, -mean * 0.5 + 1e-6) << p;
      }
    }
  }
}

}  // namespace
}  // namespace gabion::test::test_loose_soil
