// SPDX-License-Identifier: BSD-3-Clause
// When a step begins, by either method, and what is kept from one step to the next.
#include <gtest/gtest.h>

#include <array>

#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/pushed_soil.hpp"

namespace gabion::test::test_soil_step {
namespace {

constexpr double dt = 0.002;

/// A scene in implicit steps, and the same in explicit ones.
std::array<Json, 2> both_methods() {
  Json balanced = pushed();
  balanced["interfaces"][0]["method"] = "facets";
  Json in_substeps = balanced;
  in_substeps["time_integration"] = {{"scheme", "explicit"}};
  return {balanced, in_substeps};
}

/// A step begins with iteration 0: no later one may take what an earlier step has left.
TEST(SoilStep, an_iteration_of_a_step_that_has_not_begun_is_refused) {
  for (const Json& json : both_methods()) {
    const auto solver = mpm_solver<2>(json);
    InterfaceValues sent;
    const auto solve = [&](std::int64_t step, int iteration, double size) {
      solver->solve_step({step, iteration, (static_cast<double>(step) - 1) * dt, size},
                         plate_at(0.002), sent);
    };
    const auto expect_refused = [&](std::int64_t step, double size) {
      expect_error<Error>(
          [&] { solve(step, 1, size); },
          {"iteration 1 of step " + std::to_string(step), "before its iteration 0"});
    };
    expect_refused(1, dt);
    solve(1, 0, dt);
    expect_refused(1, dt / 2);
    solve(1, 1, dt);
    solver->reject_step();
    expect_refused(1, dt);
    solve(1, 0, dt);
    solver->accept_step({1, 0, 0, dt}, true);
    expect_refused(2, dt);
    solve(2, 0, dt);
    solver->accept_step({2, 0, dt, dt}, true);
  }
}

TEST(SoilStep, a_step_that_cannot_begin_fails_each_time) {
  const auto solver = mpm_solver<2>(both_methods()[1]);
  InterfaceValues sent;
  for (int k = 0; k < 2; ++k) {
    expect_error<ConvergenceError>(
        [&] {
          solver->solve_step({1, 0, 0, 1e6}, {}, sent);
        },
        {"explicit step of 1e+06 s", "substeps would be stable"});
  }
  EXPECT_EQ(solver->summary().at("explicit").at("solutions"), 0);
  EXPECT_EQ(solver->summary().at("newton").at("failures").at("substeps"), 2);
}

/// The steps of an implicit phase depend on which Krylov method has failed before the explicit one.
TEST(SoilStep, explicit_steps_keep_the_pause_of_a_krylov_method) {
  Json json = both_methods()[1];
  json["phases"] = {{{"until", 2 * dt}}, {{"time_integration", {{"scheme", "bossak"}}}}};
  const auto solver = mpm_solver<2>(json);
  State state = solver->save_state();
  state.integers.at("krylov_pause.steps") = {3};
  state.integers.at("krylov_pause.last") = {4};
  state.integers.at("krylov_pause.method") = {2};
  solver->load_state(state);
  run_steps(*solver, dt, 2);
  const State after = solver->save_state();
  for (const char* name : {"krylov_pause.steps", "krylov_pause.last", "krylov_pause.method"}) {
    EXPECT_EQ(after.integers.at(name), state.integers.at(name)) << name;
  }
}

}  // namespace
}  // namespace gabion::test::test_soil_step
