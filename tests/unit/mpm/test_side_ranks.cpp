// SPDX-License-Identifier: BSD-3-Clause
// Soil on both sides of a thin wall, on several ranks: nodes of whose two numbers a rank may have
// one, or whose points of the other side another rank has.
#include <gtest/gtest.h>

#include "tests/unit/mpm/steps_on_ranks.hpp"

namespace gabion::test::test_side_ranks {
namespace {

constexpr double h = 0.1;

struct SideCase {
  std::string basis;
  std::string locking = "none", small_cuts = "none", scheme = "explicit";
  bool tall = false;  ///< the border between two ranks goes through the wall, else along it
  double thickness = 0.5, offset = 0;  // by the cell
  double dt = 4e-4;
  int steps = 30;
};

/// Soil against both sides of a wall, and some that passes over its crest, from rank to rank.
Json scene(const SideCase& given) {
  const double left = 1 + given.offset * h, right = left + given.thickness * h;
  const int rows = given.tall ? 9 : 3;
  const double crest = h * rows - 0.05, top = h * (rows + 1);
  const Json material = elastic_soil("neo_hookean", 2e5, 0.3, 1500);
  Json json = {{"dimension", 2},
               {"grid", box({0, 0}, {2.4, 2}, {24, 20}, "quad4")},
               {"basis", given.basis},
               {"locking", {{"method", given.locking}}},
               {"small_cuts", {{"method", given.small_cuts}}},
               {"walls", {wall("bottom", "slip")}},
               {"probes", {{{"name", "A"}, {"point", {left - 0.05, 0.15}}}}},
               {"rigid_walls",
                {{{"name", "wall"},
                  {"method", "facets"},
                  {"friction", 0.3},
                  {"surface",
                   {{"polyline", {{right, -0.1}, {right, crest}, {left, crest}, {left, -0.1}}},
                    {"spacing", h}}}}}},
               {"bodies",
                {body("low", box({left - 0.3, 0}, {left, h * rows}, {3, rows}, "quad4"), 4,
                      material, {2, 0}),
                 body("high", box({left - 0.3, top}, {left, top + 0.3}, {3, 3}, "quad4"), 4,
                      material, {9, -0.5}),
                 body("behind", box({right, 0}, {right + 0.3, h * rows}, {3, rows}, "quad4"), 4,
                      material, {-1, 0})}}};
  solve_exactly(given.scheme, json);
  return json;
}

/// Take equal steps on all ranks together and on each rank alone, with a restart on the other
/// number of ranks in the middle.
void check(const SideCase& given) {
  SCOPED_TRACE(given.basis + " " + given.scheme + " " + given.locking + " " + given.small_cuts +
               (given.tall ? " tall" : "") + " thickness " + std::to_string(given.thickness) +
               " offset " + std::to_string(given.offset));
  const double tolerance = given.scheme == "explicit" ? 1e-9 : 1e-7;
  const Json json = scene(given);
  const auto shared = mpm_solver<2>(json), alone = mpm_solver<2>(json, MPI_COMM_SELF);
  run(*shared, given.dt, 1, given.steps / 2);
  run(*alone, given.dt, 1, given.steps / 2);
  expect_same_points<2>(shared->points(), alone->points(), tolerance);
  const auto spread = mpm_solver<2>(json);
  load_gathered(comm(), gather_state(MPI_COMM_SELF, alone->save_state()), *spread);
  run(*shared, given.dt, given.steps / 2 + 1, given.steps);
  run(*alone, given.dt, given.steps / 2 + 1, given.steps);
  run(*spread, given.dt, given.steps / 2 + 1, given.steps);
  for (const auto* solver : {shared.get(), spread.get()}) {
    expect_same_points<2>(solver->points(), alone->points(), tolerance);
    expect_same_probes(*solver, *alone, tolerance);
  }
  EXPECT_EQ(shared->summary()["small_cuts"], alone->summary()["small_cuts"]);
  if (size() > 1 && !given.tall) {
    EXPECT_GT(shared->summary().at("ranks").at("moved_points"), 3);
  }
}

TEST(SideRanks, number_of_ranks_does_not_change_explicit_steps) {
  for (const char* basis : {"linear", "gimp", "bspline"}) {
    check({.basis = basis, .locking = "fbar"});
    check({.basis = basis, .tall = true, .thickness = 0.25, .offset = 0.25});
  }
}

TEST(SideRanks, number_of_ranks_does_not_change_implicit_steps) {
  for (const char* basis : {"linear", "gimp", "bspline"}) {
    check({.basis = basis, .scheme = "implicit", .dt = 2e-3, .steps = 6});
  }
  check({.basis = "gimp",
         .locking = "fbar",
         .scheme = "implicit",
         .tall = true,
         .dt = 2e-3,
         .steps = 6});
}

TEST(SideRanks, number_of_ranks_does_not_change_the_cures_of_small_cuts) {
  for (const bool tall : {false, true}) {
    check({.basis = tall ? "linear" : "gimp",
           .small_cuts = "ghost",
           .scheme = "implicit",
           .tall = tall,
           .offset = 0.25,
           .dt = 2e-3,
           .steps = 6});
    check({.basis = tall ? "gimp" : "linear",
           .small_cuts = "mass_cutoff",
           .scheme = "implicit",
           .tall = tall,
           .offset = 0.25,
           .dt = 2e-3,
           .steps = 6});
  }
}

/// Soil on both sides of a plate in space, across the border between ranks.
TEST(SideRanks, in_space) {
  const Json material = elastic_soil("neo_hookean", 1e6, 0.3, 1500);
  const Json json = {{"dimension", 3},
                     {"grid", box({0, 0, 0}, {1, 0.4, 1.2}, {10, 4, 12}, "hex8")},
                     {"basis", "gimp"},
                     {"time_integration", {{"scheme", "explicit"}}},
                     {"rigid_walls",
                      {{{"name", "plate"},
                        {"method", "facets"},
                        {"surface",
                         {{"mesh", box({0, 0, 0.6}, {1, 0.4, 0.65}, {10, 4, 1}, "hex8")},
                          {"groups", {"bottom", "top"}}}}}}},
                     {"bodies",
                      {body("lower", box({0.1, 0.1, 0.4}, {0.9, 0.3, 0.6}, {8, 2, 2}, "hex8"), 8,
                            material, {4, 0, 3}),
                       body("upper", box({0.1, 0.1, 0.65}, {0.9, 0.3, 0.85}, {8, 2, 2}, "hex8"), 8,
                            material, {0, 0, -1})}}};
  const auto shared = mpm_solver<3>(json), alone = mpm_solver<3>(json, MPI_COMM_SELF);
  run(*shared, 2e-4, 1, 20);
  run(*alone, 2e-4, 1, 20);
  expect_same_points<3>(shared->points(), alone->points(), 1e-9);
  expect_same_probes(*shared, *alone, 1e-9);
}

}  // namespace
}  // namespace gabion::test::test_side_ranks
