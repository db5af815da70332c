// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"
#include "tests/unit/mpm/soil_patch.hpp"

namespace gabion::test::test_walls {
namespace {

Json moving_wall(const std::string& group, const std::string& condition,
                 const std::vector<double>& velocity) {
  Json result = wall(group, condition);
  result["motion"] = {{"velocity", velocity}};
  return result;
}

/// A bar of 1 m along x that fills its grid.
Json bar(double nu = 0.3) {
  return {{"dimension", 2},
          {"analysis", "quasi_static"},
          {"grid", box({0, 0}, {1, 0.25}, {4, 1}, "quad4")},
          {"basis", "linear"},
          {"walls", {wall("left", "slip"), wall("bottom", "slip"), wall("top", "slip")}},
          {"bodies",
           {body("soil", box({0, 0}, {1, 0.25}, {4, 1}, "quad4"), 4,
                 elastic_soil("hencky_elastic", 1e6, nu, 1000))}},
          {"newton", exact_newton}};
}

TEST(WallMotion, table_is_piecewise_linear_and_held) {
  const mpm::WallMotion motion{{}, {{1, 0, 0}, {2, 1, -2}, {4, 1, 4}}};
  EXPECT_EQ(motion.displacement<2>(0), Vector<2>(0, 0));
  EXPECT_EQ(motion.displacement<2>(1.25), Vector<2>(0.25, -0.5));
  EXPECT_EQ(motion.displacement<2>(3), Vector<2>(1, 1));
  EXPECT_EQ(motion.displacement<2>(9), Vector<2>(1, 4));
  EXPECT_EQ((mpm::WallMotion{{0.5, -1}, {}}.displacement<2>(3)), Vector<2>(1.5, -3));
  EXPECT_FALSE(mpm::WallMotion{}.moves());
}

Vector<2> inertia(const mpm::MaterialPoints<2>& points) {
  Vector<2> sum = Vector<2>::Zero();
  for (std::int32_t p = 0; p < points.size(); ++p) sum += points.m[p] * points.a[p];
  return sum;
}

/// The walls carry the weight but for what falls, and the side walls push against each other.
TEST(WallForces, balance_the_soil) {
  Json json = bar();
  json["gravity"] = {0, -10};
  json["walls"].erase(2);
  json["walls"].push_back(wall("right", "fixed"));
  json["grid"] = box({0, 0}, {1, 0.5}, {4, 2}, "quad4");
  const double weight = 250 * 10;
  for (const std::string analysis : {"quasi_static", "dynamic"}) {
    json["analysis"] = analysis;
    if (analysis == "dynamic") json["time_integration"] = trapezoid;
    const auto solver = mpm_solver<2>(json);
    run_steps(*solver, 1e-3, 1);
    const Vector<2> falls = inertia(solver->points());
    const double sum_x = probe(*solver, "wall.left.fx") + probe(*solver, "wall.right.fx");
    const double sum_y = probe(*solver, "wall.bottom.fy") + probe(*solver, "wall.right.fy");
    EXPECT_NEAR(sum_x, -falls[0], 1e-8 * weight) << analysis;
    EXPECT_NEAR(sum_y, -weight - falls[1], 1e-8 * weight) << analysis;
    EXPECT_GT(probe(*solver, "wall.right.fx"), 1) << analysis;
    EXPECT_EQ(falls[1] < 0, analysis == "dynamic");
  }
}

/// Homogeneous stretch 1 + e of a confined bar in one step: the forces are those of P = tau / (1 +
/// e) on the section before it.
TEST(MovingWall, stretches_a_bar) {
  Json json = bar(0.3);
  json["walls"].push_back(moving_wall("right", "slip", {0.02, 7}));
  const auto solver = mpm_solver<2>(json);
  run_steps(*solver, 0.5, 1);
  const double M = 1e6 * 0.7 / (1.3 * 0.4), e = 0.01;
  EXPECT_NEAR(probe(*solver, "wall.right.fx"), -M * std::log(1 + e) / (1 + e) * 0.25, 1e-6 * M);
  EXPECT_NEAR(probe(*solver, "wall.left.fx"), -probe(*solver, "wall.right.fx"), 1e-6 * M);
  const auto& points = solver->points();
  for (std::int32_t p = 0; p < points.size(); ++p) {
    EXPECT_NEAR(points.u[p][0], e * (points.x[p][0] - points.u[p][0]), 1e-12);
    EXPECT_NEAR(points.u[p][1], 0, 1e-12);
  }
}

/// Walls that move with the soil do not push it: dynamic, every point keeps its velocity.
TEST(MovingWall, that_moves_with_the_soil_exerts_no_force) {
  const std::vector<double> v = {0.03, 0};
  Json json = bar();
  json["analysis"] = "dynamic";
  json["bodies"][0]["velocity"] = v;
  json["walls"] = {moving_wall("left", "fixed", v), moving_wall("right", "slip", v)};
  const auto solver = mpm_solver<2>(json);
  run_steps(*solver, 0.1, 5);
  const auto& points = solver->points();
  for (std::int32_t p = 0; p < points.size(); ++p) {
    EXPECT_LT((points.v[p] - Vector<2>(0.03, 0)).norm(), 1e-12);
    EXPECT_NEAR(points.u[p][0], 0.015, 1e-13);
  }
  EXPECT_NEAR(probe(*solver, "wall.left.fx"), 0, 1e-6);
  EXPECT_NEAR(probe(*solver, "wall.right.fx"), 0, 1e-6);
}

/// Soil at rest that a wall runs into: the wall gives it the momentum M V of half a cell, the mass
/// of its nodes. The trapezoidal rule adds the force at the end, m a dt / 2. The probe has both.
TEST(MovingWall, gives_its_impulse_to_the_soil) {
  const double V = 0.5, stop = 1000 * 0.25 * 0.25 / 2 * V, dt = 1e-3;
  Json json = bar();
  json["analysis"] = "dynamic";
  json["time_integration"] = trapezoid;
  json["walls"] = {moving_wall("left", "fixed", {V, 0})};
  const auto solver = mpm_solver<2>(json);
  for (int n = 1; n <= 5; ++n) {
    run_steps(*solver, dt, 1, n);
    const double momentum = probe(*solver, "momentum_x"), F = probe(*solver, "wall.left.fx");
    if (n == 1) {
      const double accelerates = inertia(solver->points())[0];
      EXPECT_NEAR(momentum, stop + accelerates * dt / 2, 0.05 * momentum);
      EXPECT_NEAR(F, -accelerates - stop / dt, 0.05 * std::abs(F));
    }
    EXPECT_NEAR(probe(*solver, "momentum_error_x"), 0, 1e-12 * momentum) << n;
    EXPECT_NEAR(probe(*solver, "energy_balance"), 0, 1e-3 * probe(*solver, "boundary_work")) << n;
    EXPECT_LT(F, -100) << n;
  }
}

/// The wall's work is the mean force times the displacement: in a linear bar the elastic energy, in
/// steps of any size.
TEST(MovingWall, work_on_an_elastic_bar) {
  for (const int steps : {1, 4}) {
    Json json = bar();
    json["bodies"][0]["material"]["law"] = "linear_elastic";
    json["walls"].push_back(moving_wall("right", "slip", {-1e-3, 0}));
    const auto solver = mpm_solver<2>(json);
    run_steps(*solver, 1.0 / steps, steps);
    const double elastic = probe(*solver, "elastic_energy");
    EXPECT_GT(elastic, 0.1);
    EXPECT_NEAR(probe(*solver, "boundary_work"), elastic, 1e-6 * elastic) << steps;
    EXPECT_NEAR(probe(*solver, "time_damping"), 0, 1e-3 * elastic) << steps;
    EXPECT_NEAR(probe(*solver, "energy_balance"), 0, 1e-6 * elastic) << steps;
  }
}

/// A bar whose foot is shaken, below resonance: the trapezoidal rule damps little, and the ledger
/// knows of hardly any energy that the wall did not give.
TEST(MovingWall, shaken_foot_gives_all_the_energy) {
  Json json = bar();
  json["analysis"] = "dynamic";
  json["time_integration"] = trapezoid;
  json["walls"][0]["motion"] = {{"table", Json::array()}};
  for (int k = 0; k <= 400; ++k) {
    const double t = 1e-3 * k;
    json["walls"][0]["motion"]["table"].push_back({t, 1e-5 * (1 - std::cos(30 * t)), 0.0});
  }
  const auto solver = mpm_solver<2>(json);
  double most = 0, damping = 0;
  for (int n = 1; n <= 100; ++n) {
    run_steps(*solver, 4e-3, 1, n);
    most = std::max(most, probe(*solver, "kinetic_energy") + probe(*solver, "elastic_energy"));
    damping = std::max(damping, std::abs(probe(*solver, "time_damping")));
  }
  EXPECT_LT(damping, 0.05 * most);
  EXPECT_LT(probe(*solver, "created_energy"), 0.05 * most);
}

TEST(MovingWall, contradicting_walls_are_refused) {
  Json json = bar();
  json["walls"] = {wall("bottom", "fixed"), moving_wall("right", "slip", {0.01, 0})};
  expect_error<ConfigError>([&] { make_mpm(json); },
                            {"/walls/1/group", "\"right\"", "\"bottom\"", "grid node"});
}

/// The set-up finds what is wrong in a later phase only, or from a row of a table on.
TEST(MovingWall, contradictions_of_a_later_phase_are_refused_at_once) {
  Json json = bar();
  json["walls"] = {wall("bottom", "fixed")};
  json["phases"] = {{{"until", 1}}, {{"walls", {wall("bottom", "fixed"), wall("right", "slip")}}}};
  Json& motion = json["phases"][1]["walls"][1]["motion"];
  // Along the wall it may move, before the phase too.
  motion = {{"table", {{0, 0, 0}, {0.5, 0.1, 0}, {1, 0.1, 0}, {2, 0.1, 3}, {3, 0.1, 0}}}};
  EXPECT_NO_THROW(make_mpm(json));
  motion["table"].push_back({4, 0.1001, 0});
  expect_error<ConfigError>([&] { make_mpm(json); }, {"/phases/1/walls/1/group", "\"right\"",
                                                      "\"bottom\"", "grid node", "from 3 s on"});
}

}  // namespace
}  // namespace gabion::test::test_walls
