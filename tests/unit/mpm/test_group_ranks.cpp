// SPDX-License-Identifier: BSD-3-Clause
// Groups of bodies in contact on several ranks: each contact node is carried by one of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/unit/mpm/steps_on_ranks.hpp"

namespace gabion::test::test_group_ranks {
namespace {

struct GroupCase {
  std::string basis;
  std::string scheme = "explicit", locking = "none";
  double dt = 4e-4;
  int steps = 30;
};

Json group(const std::string& name, const std::vector<std::string>& bodies) {
  return {{"name", name}, {"bodies", bodies}};
}

/// A long bed of two bodies, and two blocks that slide along it, from rank to rank; the second one
/// falls on it.
Json scene(const GroupCase& given) {
  const Json soil = elastic_soil("neo_hookean", 2e5, 0.3, 1500);
  Json json = {
      {"dimension", 2},
      {"grid", box({0, 0}, {3, 1.2}, {30, 12}, "quad4")},
      {"basis", given.basis},
      {"locking", {{"method", given.locking}}},
      {"walls", {wall("bottom", "fixed")}},
      {"gravity", {0, -9.81}},
      {"probes", {{{"name", "A"}, {"point", {1.15, 0.5}}}}},
      {"bodies",
       {body("bed", box({0.2, 0}, {1.4, 0.4}, {12, 4}, "quad4"), 4, soil),
        body("bed_2", box({1.4, 0}, {2.8, 0.4}, {14, 4}, "quad4"), 4, soil),
        body("block", box({1.0, 0.4}, {1.5, 0.7}, {5, 3}, "quad4"), 4, soil, {6, -0.5}),
        body("other", box({1.87, 0.404}, {2.27, 0.704}, {4, 3}, "quad4"), 4, soil, {-3, -1})}},
      {"contact_groups",
       {{"groups",
         {group("bed", {"bed", "bed_2"}), group("block", {"block"}), group("other", {"other"})}},
        {"pairs",
         {{{"groups", {"bed", "block"}}, {"friction", 0.3}},
          {{"groups", {"bed", "other"}}, {"friction", 0.5}},
          {{"groups", {"block", "other"}}, {"friction", 0.2}}}}}}};
  if (given.scheme != "explicit") json["time_integration"] = {{"scheme", given.scheme}};
  solve_exactly(given.scheme, json);
  return json;
}

double probe_of(const Solver& solver, const std::string& name) {
  const auto names = solver.probe_names();
  const auto found = std::ranges::find(names, name);
  EXPECT_NE(found, names.end()) << name;
  return found == names.end() ? NAN : solver.probes()[found - names.begin()];
}

/// Take equal steps on all ranks together and on each rank alone, with a restart on the other
/// number of ranks in the middle, in both directions.
void check(const GroupCase& given) {
  SCOPED_TRACE(given.basis + " " + given.scheme + " " + given.locking);
  const double tolerance = given.scheme == "explicit" ? 1e-8 : 1e-7;
  const Json json = scene(given);
  const auto shared = mpm_solver<2>(json), alone = mpm_solver<2>(json, MPI_COMM_SELF);
  run(*shared, given.dt, 1, given.steps / 2);
  run(*alone, given.dt, 1, given.steps / 2);
  expect_same_points<2>(shared->points(), alone->points(), tolerance);
  const State from_shared = gather_state(comm(), shared->save_state());
  const auto spread = mpm_solver<2>(json);
  load_gathered(comm(), gather_state(MPI_COMM_SELF, alone->save_state()), *spread);
  for (auto* solver : {shared.get(), alone.get(), spread.get()}) {
    run(*solver, given.dt, given.steps / 2 + 1, given.steps);
  }
  for (const auto* solver : {shared.get(), spread.get()}) {
    expect_same_points<2>(solver->points(), alone->points(), tolerance);
    expect_same_probes(*solver, *alone, tolerance);
  }
  EXPECT_GT(std::abs(probe_of(*alone, "contact.bed.block.fy")), 100);
  EXPECT_GT(std::abs(probe_of(*alone, "contact.bed.other.fy")), 1);
  EXPECT_GT(probe_of(*alone, "contact_friction"), 0);
  if (rank() == 0) {
    const auto joined = mpm_solver<2>(json, MPI_COMM_SELF);
    load_gathered(MPI_COMM_SELF, from_shared, *joined);
    run(*joined, given.dt, given.steps / 2 + 1, given.steps);
    expect_same_probes(*joined, *alone, tolerance);
  }
  if (size() > 1) {
    EXPECT_GT(shared->summary().at("ranks").at("moved_points"), 3);
  }
}

TEST(GroupRanks, number_of_ranks_does_not_change_explicit_steps) {
  for (const char* basis : {"linear", "gimp", "bspline"}) check({.basis = basis});
  check({.basis = "gimp", .locking = "fbar"});
}

TEST(GroupRanks, number_of_ranks_does_not_change_implicit_steps) {
  check({.basis = "linear", .scheme = "newmark", .dt = 2e-3, .steps = 6});
  check({.basis = "gimp", .scheme = "newmark", .dt = 2e-3, .steps = 6});
  check({.basis = "gimp", .scheme = "newmark", .locking = "fbar", .dt = 2e-3, .steps = 6});
}

}  // namespace
}  // namespace gabion::test::test_group_ranks
