// SPDX-License-Identifier: BSD-3-Clause
// A run stops in the middle and goes on, on as many ranks or on others.
#include <gtest/gtest.h>

#include "common/mechanics/ranks/sum.hpp"
#include "solver_program/ranked_state.hpp"
#include "solver_program/ranked_state_file.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/collapse.hpp"

namespace gabion::test::test_restart_on_ranks {
namespace {

constexpr int half = 20, all = 40;

/// On as many ranks every bit is restored, the partition included. On several ranks MUMPS adds in
/// the order of messages, so the steps are solved by conjugate gradients there.
TEST(RestartOnRanks, the_same_number_gives_the_same_bits) {
  for (const bool slides : {false, true}) {
    const Collapse soil = {.basis = "gimp", .law = "neo_hookean"};
    Json json = slides ? sliding_scene(soil) : collapse_scene(soil);
    json["linear_solver"] = {{"method", slides ? "gmres" : "cg"}};
    const auto straight = mpm_solver<2>(json), first = mpm_solver<2>(json),
               second = mpm_solver<2>(json);
    run_collapse(*straight, 1, all);
    run_collapse(*first, 1, half);
    const State saved = gather_state(comm(), first->save_state());
    load_gathered(comm(), saved, *second);
    EXPECT_TRUE(same_bits<2>(second->points(), first->points()));
    run_collapse(*second, half + 1, all);
    EXPECT_TRUE(same_bits<2>(second->points(), straight->points()));
    EXPECT_EQ(second->probes(), straight->probes());
    if (size() > 1) {
      EXPECT_GT(straight->summary().at("ranks").at("moved_points"), 10);
      EXPECT_EQ(straight->summary().at("ranks"), second->summary().at("ranks"));
    }
  }
}

/// Restarts go from all ranks to one each, and from one to all.
TEST(RestartOnRanks, another_number_gives_the_same_values) {
  for (const bool slides : {false, true}) {
    const Json json = slides ? sliding_scene({}) : collapse_scene({});
    const auto alone = mpm_solver<2>(json, MPI_COMM_SELF), shared = mpm_solver<2>(json);
    run_collapse(*alone, 1, half);
    run_collapse(*shared, 1, half);
    const State from_alone = gather_state(MPI_COMM_SELF, alone->save_state());
    State from_shared = gather_state(comm(), shared->save_state());

    const auto spread = mpm_solver<2>(json);
    load_gathered(comm(), from_alone, *spread);
    expect_same_points<2>(spread->points(), alone->points(), 0);
    run_collapse(*alone, half + 1, all);
    run_collapse(*spread, half + 1, all);
    expect_same_points<2>(spread->points(), alone->points(), 1e-8);
    expect_same_probes(*spread, *alone, 1e-5);

    if (rank() == 0) {
      const auto joined = mpm_solver<2>(json, MPI_COMM_SELF);
      load_gathered(MPI_COMM_SELF, from_shared, *joined);
      run_collapse(*joined, half + 1, all);
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

/// The first ranks of all, as many as are wanted; MPI_COMM_NULL on the others.
MPI_Comm first_ranks(int number) {
  MPI_Comm some = MPI_COMM_NULL;
  MPI_Comm_split(comm(), rank() < number ? 0 : MPI_UNDEFINED, rank(), &some);
  return some;
}

/// Half a run on some ranks, then a file, and the rest on others: but for rounding the same as
/// the run in one piece on one rank.
void expect_same_run(const Json& json, const mpm::MpmSolver<2>& straight, int ranks_before,
                     int ranks_after) {
  SCOPED_TRACE(std::to_string(ranks_before) + " -> " + std::to_string(ranks_after));
  const std::string path = testing::TempDir() + "gabion_restart_on_ranks.h5";
  if (MPI_Comm some = first_ranks(ranks_before); some != MPI_COMM_NULL) {
    const auto first = mpm_solver<2>(json, some);
    run_collapse(*first, 1, half);
    write_ranked_state(some, path, first->save_state());
    MPI_Comm_free(&some);
  }
  MPI_Barrier(comm());
  if (MPI_Comm some = first_ranks(ranks_after); some != MPI_COMM_NULL) {
    const auto second = mpm_solver<2>(json, some);
    load_ranked_state(some, path, *second);
    run_collapse(*second, half + 1, all);
    const auto &a = second->points(), &b = straight.points();
    double count = static_cast<double>(a.size());
    sum_over_ranks(some, std::span<double>(&count, 1));
    EXPECT_EQ(count, static_cast<double>(b.size()));
    for (std::int32_t p = 0; p < a.size(); ++p) {
      const std::int32_t q = mpm::find_point(b, a.id[p]);
      ASSERT_GE(q, 0);
      EXPECT_LT((a.x[p] - b.x[q]).norm(), 1e-8);
      EXPECT_LT((a.v[p] - b.v[q]).norm(), 1e-7);
    }
    expect_same_probes(*second, straight, 1e-5);
    MPI_Comm_free(&some);
  }
  MPI_Barrier(comm());
}

TEST(RestartOnRanks, a_file_of_other_ranks_gives_the_same_values) {
  if (size() == 1) return;
  for (const bool slides : {false, true}) {
    const Json json = slides ? sliding_scene({}) : collapse_scene({});
    const auto straight = mpm_solver<2>(json, MPI_COMM_SELF);
    run_collapse(*straight, 1, all);
    expect_same_run(json, *straight, size() - 1, size());
    expect_same_run(json, *straight, size(), 1);
  }
}

/// A rank reads what it goes on with, and of others only what is equal on all.
TEST(RestartOnRanks, no_rank_takes_the_points_of_all) {
  const std::string path = testing::TempDir() + "gabion_restart_shares.h5";
  const auto solver = mpm_solver<2>(collapse_scene({}));
  const State state = solver->save_state();
  write_ranked_state(comm(), path, state);
  class Taker : public Solver {
   public:
    std::size_t num_points = 0;
    std::vector<InterfaceMesh> interfaces() const override { return {}; }
    std::vector<std::string> probe_names() const override { return {}; }
    StepReport solve_step(const StepRequest&, const InterfaceValues&, InterfaceValues&) override {
      return {};
    }
    AcceptReport accept_step(const StepRequest&, bool) override { return {}; }
    void reject_step() override {}
    void write_output(double) override {}
    std::vector<double> probes() const override { return {}; }
    Json summary() const override { return {}; }
    bool joins_states() const override { return true; }
    void join_states(const State& first, std::span<const State> own) override {
      if (rank() != 0) {
        EXPECT_FALSE(first.reals.contains("points.x"));
      }
      for (const State& part : own) num_points += part.reals.at("points.m").size();
    }
  } taker;
  if (MPI_Comm some = first_ranks(size() - 1); size() > 1 && some != MPI_COMM_NULL) {
    load_ranked_state(some, path, taker);
    EXPECT_LT(taker.num_points, size() == 2 ? 241u : 200u);
    MPI_Comm_free(&some);
  }
  auto count = static_cast<double>(taker.num_points);
  sum_over_ranks(comm(), std::span<double>(&count, 1));
  EXPECT_EQ(count, size() == 1 ? 0 : 240);
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
}  // namespace gabion::test::test_restart_on_ranks
