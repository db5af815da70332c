// SPDX-License-Identifier: BSD-3-Clause
// A run stops in the middle and goes on, on as many ranks or on others.
#include <gtest/gtest.h>

#include "solver_program/ranked_state.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/collapse.hpp"

namespace gabion::test {
namespace {

constexpr int half = 20, all = 40;

/// The same ranks: every bit, the partition included. On several ranks MUMPS adds in the order of
/// messages, so the steps are solved by conjugate gradients there.
TEST(RestartOnRanks, the_same_number_gives_the_same_bits) {
  for (const bool slides : {false, true}) {
    const Collapse soil = {.basis = "gimp", .law = "neo_hookean"};
    Json json = slides ? sliding_scene(soil) : collapse_scene(soil);
    json["linear_solver"] = {{"method", slides ? "gmres" : "cg"}};
    const auto straight = mpm_solver<2>(json), first = mpm_solver<2>(json),
               second = mpm_solver<2>(json);
    run_steps(*straight, 1, all);
    run_steps(*first, 1, half);
    const State saved = gather_state(comm(), first->save_state());
    load_gathered(comm(), saved, *second);
    EXPECT_TRUE(same_bits<2>(second->points(), first->points()));
    run_steps(*second, half + 1, all);
    EXPECT_TRUE(same_bits<2>(second->points(), straight->points()));
    EXPECT_EQ(second->probes(), straight->probes());
    if (size() > 1) {
      EXPECT_GT(straight->summary().at("ranks").at("moved_points"), 10);
      EXPECT_EQ(straight->summary().at("ranks"), second->summary().at("ranks"));
    }
  }
}

/// From all ranks to one each, and from one to all.
TEST(RestartOnRanks, another_number_gives_the_same_values) {
  for (const bool slides : {false, true}) {
    const Json json = slides ? sliding_scene({}) : collapse_scene({});
    const auto alone = mpm_solver<2>(json, MPI_COMM_SELF), shared = mpm_solver<2>(json);
    run_steps(*alone, 1, half);
    run_steps(*shared, 1, half);
    const State from_alone = gather_state(MPI_COMM_SELF, alone->save_state());
    State from_shared = gather_state(comm(), shared->save_state());

    const auto spread = mpm_solver<2>(json);
    load_gathered(comm(), from_alone, *spread);
    expect_same_points<2>(spread->points(), alone->points(), 0);
    run_steps(*alone, half + 1, all);
    run_steps(*spread, half + 1, all);
    expect_same_points<2>(spread->points(), alone->points(), 1e-8);
    expect_same_probes(*spread, *alone, 1e-5);

    if (rank() == 0) {
      const auto joined = mpm_solver<2>(json, MPI_COMM_SELF);
      load_gathered(MPI_COMM_SELF, from_shared, *joined);
      run_steps(*joined, half + 1, all);
      const auto &a = joined->points(), &b = alone->points();
      ASSERT_EQ(a.id, b.id);
      for (std::int32_t p = 0; p < a.size(); ++p) {
        EXPECT_LT((a.x[p] - b.x[p]).norm(), 1e-8);
        EXPECT_LT((a.v[p] - b.v[p]).norm(), 1e-8);
      }
      expect_same_probes(*joined, *alone, 1e-5);
    }
  }
}

TEST(RestartOnRanks, a_state_of_other_points_is_refused_on_all_ranks) {
  const Json json = collapse_scene({});
  const State good = mpm_solver<2>(json)->save_state();
  const auto expect_refused = [&](const State& state, const std::string& text) {
    const auto solver = mpm_solver<2>(json);
    expect_error<Error>([&] { solver->load_state(state); }, {text});
  };
  State state = good;
  if (rank() == size() - 1) state.reals.at("points.m").pop_back();
  expect_refused(state, "points.m: found");
  state = good;
  if (rank() == 0) state.integers.at("points.id").back() = 100000;
  expect_refused(state, "points.id: found 100000, allowed: 0 to 239");
  state = good;
  if (rank() == 0) state.integers.at("points.id")[1] = state.integers.at("points.id")[0];
  expect_refused(state, "points.id: found an id twice");
  state = good;
  state.integers.at("removed_points")[0] = 1;
  expect_refused(state, "found 241 material points, those that left included, allowed: 240");
}

}  // namespace
}  // namespace gabion::test
