// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/expect_error.hpp"
#include "tests/unit/fem/plate.hpp"

namespace gabion::test {
namespace {

void expect_equal_on_ranks(ForceKind kind) {
  const auto shared = fem_solver<2>(plate());
  const auto alone = fem_solver<2>(plate(), MPI_COMM_SELF);
  shared->set_force_kinds({{"wall", kind}});
  alone->set_force_kinds({{"wall", kind}});
  const auto load = push(*shared, 5);
  InterfaceValues shared_sent, alone_sent;
  for (int n = 1; n <= 5; ++n) {
    const StepRequest request{n, 0, (n - 1) * 0.02, 0.02};
    shared->solve_step(request, load, shared_sent);
    alone->solve_step(request, load, alone_sent);
    const auto shared_probes = shared->accept_step(request, true).probes;
    const auto alone_probes = alone->accept_step(request, true).probes;
    for (std::size_t i = 0; i < alone_probes.size(); ++i) {
      EXPECT_NEAR(shared_probes[i], alone_probes[i], 1e-10 * (1 + std::abs(alone_probes[i])));
    }
  }
  double largest = 0;
  for (const double u : alone_sent.at("wall")) largest = std::max(largest, std::abs(u));
  ASSERT_GT(largest, 1e-3);
  for (std::size_t i = 0; i < alone_sent.at("wall").size(); ++i) {
    EXPECT_NEAR(shared_sent.at("wall")[i], alone_sent.at("wall")[i], 1e-10 * largest);
  }
}

TEST(FemRanks, ranks_agree_with_one_rank) {
  expect_equal_on_ranks(ForceKind::end_of_step);
  expect_equal_on_ranks(ForceKind::step_mean);
}

TEST(FemRanks, failure_leaves_the_accepted_state) {
  const auto solver = fem_solver<2>(plate());
  const State before = solver->save_state();
  InterfaceValues sent;
  auto broken = push(*solver, 1);
  broken["wall"][3] = std::nan("");
  expect_error<ConvergenceError>(
      [&] {
        solver->solve_step({1, 0, 0, 0.01}, broken, sent);
      },
      {"guess is inadmissible", "force not finite at node"});
  const State after = solver->save_state();
  EXPECT_EQ(after.reals, before.reals);
  EXPECT_EQ(after.integers, before.integers);
  EXPECT_EQ(after.facts, before.facts);
  expect_error<Error>(
      [&] {
        solver->accept_step({1, 0, 0, 0.01}, true);
      },
      {"step 1: accepted without a solution"});
}

}  // namespace
}  // namespace gabion::test
