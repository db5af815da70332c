// SPDX-License-Identifier: BSD-3-Clause
// Soil whose pore water drains, on several ranks and on one.
#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "solver_program/ranked_state.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/collapse.hpp"
#include "tests/unit/mpm/saturated_soil.hpp"

namespace gabion::test::test_seepage_ranks {
namespace {

constexpr int half = 8, all = 16;

/// A column of saturated soil beside a dry one that collapse onto a floor: surfaces in air cross
/// the parts of the ranks, and points go from rank to rank.
Json wet_collapse(const std::string& basis, const std::string& permeability_law = "constant") {
  Json json = collapse_scene({.basis = basis, .locking = "fbar"});
  Json& soil = json["bodies"][0];
  soil["mesh"] = box({0, 0}, {1.0, 1.0}, {10, 10}, "quad4");
  soil["material"] = saturated_sand();
  soil["water"] = pore_water;
  soil["water"]["permeability"] = 1e-3;
  soil["water"]["permeability_law"] = permeability_law;
  Json& dry = json["bodies"][1];
  dry["mesh"] = box({1.0, 0}, {1.4, 0.6}, {4, 6}, "quad4");
  dry["material"] = saturated_sand();
  for (Json& body : json["bodies"]) body["velocity"] = {2.5, 0};
  json["walls"] = {wall("bottom", "slip"), wall("left", "slip")};
  json["walls"][1]["drained"] = true;
  json["rigid_walls"] = {{{"name", "step"},
                          {"surface", {{"polyline", {{1.9, 0.8}, {1.9, -0.1}}}, {"spacing", 0.1}}},
                          {"friction", 0.3}}};
  return json;
}

/// Points of this rank have what they have alone, but for rounding.
void expect_same_water(const mpm::MpmSolver<2>& shared, const mpm::MpmSolver<2>& alone,
                       double tolerance) {
  const auto &a = shared.points(), &b = alone.points();
  double count = static_cast<double>(a.size());
  MPI_Allreduce(MPI_IN_PLACE, &count, 1, MPI_DOUBLE, MPI_SUM, comm());
  EXPECT_EQ(count, static_cast<double>(b.size()));
  for (std::int32_t p = 0; p < a.size(); ++p) {
    const std::int32_t q = mpm::find_point(b, a.id[p]);
    ASSERT_GE(q, 0);
    SCOPED_TRACE("point " + std::to_string(a.id[p]));
    EXPECT_LT((a.x[p] - b.x[q]).norm(), tolerance);
    EXPECT_LT((a.v[p] - b.v[q]).norm(), 1e2 * tolerance);
    EXPECT_LT((a.tau[p] - b.tau[q]).norm(), 2e7 * tolerance);
    EXPECT_NEAR(a.J[p], b.J[q], 10 * tolerance);
    EXPECT_NEAR(a.water[p], b.water[q], 10 * tolerance);
    EXPECT_NEAR(a.m[p], b.m[q], 10 * tolerance * b.m[q]);
  }
}

void expect_same_outflow(const Solver& shared, const Solver& alone) {
  const double out = probe(alone, "water_out");
  EXPECT_GT(std::abs(out), 0.1);
  EXPECT_NEAR(probe(shared, "water_out"), out, 1e-6 * std::abs(out));
  for (const char* name : {"step.fx", "step.fy", "plastic_dissipation", "gravity_work"}) {
    const double value = probe(alone, name);
    EXPECT_NEAR(probe(shared, name), value, 1e-5 * (1 + std::abs(value))) << name;
  }
}

TEST(SeepageRanks, explicit_steps_are_refused_on_several_ranks) {
  Json json = wet_collapse("gimp");
  json["time_integration"] = {{"scheme", "explicit"}};
  json.erase("newton");
  json.erase("linear_solver");
  if (size() == 1) return;
  expect_error<ConfigError>([&] { mpm_solver<2>(json); },
                            {"permeability", "explicit", std::to_string(size()) + " ranks"});
}

TEST(SeepageRanks, number_of_ranks_does_not_change_the_result) {
  for (const auto& [basis, law] :
       {std::pair("gimp", "kozeny_carman"), std::pair("bspline", "constant")}) {
    SCOPED_TRACE(std::string(basis) + " " + law);
    const Json json = wet_collapse(basis, law);
    const auto shared = mpm_solver<2>(json), alone = mpm_solver<2>(json, MPI_COMM_SELF);
    run_collapse(*shared, 1, all);
    run_collapse(*alone, 1, all);
    expect_same_water(*shared, *alone, 1e-7);
    expect_same_outflow(*shared, *alone);
    if (size() > 1) {
      EXPECT_GT(shared->summary().at("ranks").at("moved_points"), 10);
    }
  }
}

/// Soil at rest under its water table, by the equilibrium of the start.
TEST(SeepageRanks, start_under_a_water_table_is_the_same) {
  Json json = saturated_box(2, "quad4", 4, saturated_elastic());
  json["basis"] = "gimp";
  json["bodies"][0]["water"]["permeability"] = 1e-4;
  json["bodies"][0]["initial_stress"] = at_rest(1);
  const auto shared = mpm_solver<2>(json), alone = mpm_solver<2>(json, MPI_COMM_SELF);
  run_collapse(*shared, 1, 3);
  run_collapse(*alone, 1, 3);
  expect_same_water(*shared, *alone, 1e-9);
  for (const auto& u : shared->points().u) EXPECT_LT(u.norm(), 1e-6 / 4);
}

/// A river that rises over soil beside a wall: what it presses on is counted once.
TEST(SeepageRanks, pools_are_the_same) {
  Json json = saturated_box(2, "quad4", 4, saturated_elastic());
  json["basis"] = "gimp";
  json["grid"] = box({0, 0}, {1.5, 1.5}, {6, 6}, "quad4");
  json["walls"] = {wall("bottom", "slip"), wall("left", "slip")};
  json["bodies"][0]["water"]["permeability"] = 1e-4;
  json["pools"] = {{{"table", {{0, 1}, {0.1, 3}}}, {"to", 0.5}}, {{"level", 1.2}, {"from", 0.9}}};
  json["rigid_walls"] = {{{"name", "step"},
                          {"surface", {{"polyline", {{1, 1.4}, {1, 0}}}, {"spacing", 0.1}}},
                          {"friction", 0.3}}};
  const auto shared = mpm_solver<2>(json), alone = mpm_solver<2>(json, MPI_COMM_SELF);
  run_collapse(*shared, 1, all);
  run_collapse(*alone, 1, all);
  expect_same_water(*shared, *alone, 1e-8);
  for (const char* name : {"step.fx", "step.mz", "wall.bottom.fy", "water_out", "boundary_work",
                           "momentum_error_x", "energy_balance"}) {
    const double value = probe(*alone, name);
    EXPECT_NEAR(probe(*shared, name), value, 1e-6 * (1 + std::abs(value))) << name;
  }
  EXPECT_GT(probe(*alone, "step.fx"), 1000);
}

/// Restarts go from all ranks to one each, and from one to all.
TEST(SeepageRanks, run_goes_on_with_another_number) {
  const Json json = wet_collapse("gimp");
  const auto alone = mpm_solver<2>(json, MPI_COMM_SELF), shared = mpm_solver<2>(json);
  run_collapse(*alone, 1, half);
  run_collapse(*shared, 1, half);
  const State from_alone = gather_state(MPI_COMM_SELF, alone->save_state());
  State from_shared = gather_state(comm(), shared->save_state());
  run_collapse(*alone, half + 1, all);
  const auto spread = mpm_solver<2>(json);
  load_gathered(comm(), from_alone, *spread);
  run_collapse(*spread, half + 1, all);
  expect_same_water(*spread, *alone, 1e-7);
  expect_same_outflow(*spread, *alone);
  if (rank() != 0) return;
  const auto joined = mpm_solver<2>(json, MPI_COMM_SELF);
  load_gathered(MPI_COMM_SELF, from_shared, *joined);
  run_collapse(*joined, half + 1, all);
  expect_same_outflow(*joined, *alone);
  const auto &a = joined->points(), &b = alone->points();
  ASSERT_EQ(a.id, b.id);
  for (std::int32_t p = 0; p < a.size(); ++p) EXPECT_LT((a.x[p] - b.x[p]).norm(), 1e-7);
}

}  // namespace
}  // namespace gabion::test::test_seepage_ranks
