// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "common/run/time_steps.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test::test_phases {
namespace {

Json soil_behind_a_gate() {
  return {{"dimension", 2},
          {"grid", box({0, 0}, {1, 0.75}, {4, 3}, "quad4")},
          {"basis", "linear"},
          {"gravity", {0, -10}},
          {"walls", {wall("bottom", "slip"), wall("left", "slip"), wall("right", "slip")}},
          {"bodies",
           {body("soil", box({0, 0}, {1, 0.5}, {4, 2}, "quad4"), 4,
                 elastic_soil("hencky_elastic", 1e6, 0.3, 1000))}},
          {"newton", exact_newton}};
}

/// The time loop of a lone run, without its files.
std::vector<double> times_of_run(Solver& solver, const TimeSettings& settings) {
  TimeSteps steps(settings);
  std::vector<double> times;
  InterfaceValues sent;
  while (!steps.finished()) {
    const StepRequest request{steps.step(), 0, steps.time(), steps.dt()};
    try {
      solver.solve_step(request, {}, sent);
      steps.accept(solver.accept_step(request, true).proposed_dt);
      times.push_back(steps.time());
    } catch (const ConvergenceError& error) {
      solver.reject_step();
      steps.cut(error.what());
    }
  }
  return times;
}

void run_steps_from(Solver& solver, double time, double dt, int count) {
  for (int n = 0; n < count; ++n) {
    const StepRequest request{n + 1, 0, time + n * dt, dt};
    InterfaceValues sent;
    solver.solve_step(request, {}, sent);
    solver.accept_step(request, true);
  }
}

TEST(LoadRamp, linear_and_smooth) {
  const mpm::LoadRamp linear{1, 4, false, 0, 1}, smooth{1, 4, true, 1, 3};
  EXPECT_EQ(linear.at(0), 0);
  EXPECT_EQ(linear.at(2), 0.25);
  EXPECT_EQ(linear.at(9), 1);
  EXPECT_EQ(smooth.at(0), 1);
  EXPECT_NEAR(smooth.at(2), 1 + 2 * (0.0625 * 2.5), 1e-15);
  EXPECT_NEAR(smooth.at(1 + 4e-6), 1, 1e-11);
  EXPECT_EQ(smooth.at(5), 3);
  EXPECT_EQ(mpm::LoadRamp{}.at(0), 1);
}

/// Under half of the ramp the floor carries half of the weight.
TEST(LoadRamp, scales_gravity) {
  Json json = soil_behind_a_gate();
  json["analysis"] = "quasi_static";
  json["gravity_ramp"] = {{"duration", 4.0}};
  const auto solver = make_mpm(json);
  for (int n = 1; n <= 5; ++n) {
    run_steps(*solver, 1, 1, n);
    EXPECT_NEAR(probe(*solver, "wall.bottom.fy"), -5000 * std::min(1.0, n / 4.0), 1e-5);
  }
}

TEST(Phases, steps_end_where_phases_do) {
  Json json = soil_behind_a_gate();
  json["phases"] = {{{"until", 0.375}, {"analysis", "quasi_static"}, {"dt", 0.25}},
                    {{"until", 0.40625}, {"dt", 0.0078125}},
                    {{"analysis", "quasi_static"}}};
  const auto solver = make_mpm(json);
  const auto times = times_of_run(*solver, {.end = 1, .dt = 0.5, .dt_min = 0.001});
  const std::vector<double> expected = {0.25, 0.375, 0.3828125, 0.390625, 0.3984375, 0.40625};
  ASSERT_GT(times.size(), expected.size());
  for (std::size_t k = 0; k < expected.size(); ++k) EXPECT_EQ(times[k], expected[k]);
  EXPECT_EQ(times.back(), 1);
}

/// The column stands between its walls; they vanish, and it falls: whatever the stress does inside,
/// momentum grows by weight times dt from the first step on, though no acceleration was known.
TEST(Phases, released_soil_gains_exactly_the_momentum_of_its_weight) {
  Json json = soil_behind_a_gate();
  json["phases"] = {{{"until", 1.0}, {"analysis", "quasi_static"}},
                    {{"walls", Json::array({wall("top", "slip")})}}};
  const auto solver = mpm_solver<2>(json);
  run_steps(*solver, 1, 1);
  EXPECT_NEAR(probe(*solver, "wall.bottom.fy"), -5000, 1e-5);
  EXPECT_EQ(probe(*solver, "momentum_y"), 0);
  const double dt = 0.001;
  run_steps_from(*solver, 1.0, dt, 1);
  EXPECT_NEAR(probe(*solver, "momentum_y"), -5000 * dt, 1e-9 * 5000);
  run_steps_from(*solver, 1.0 + dt, dt, 3);
  EXPECT_NEAR(probe(*solver, "momentum_y"), -5000 * 4 * dt, 1e-9 * 5000);
  EXPECT_EQ(probe(*solver, "wall.bottom.fy"), 0);
}

/// Steps are functions of the accepted state and the time: repeating and rejecting change no bit.
TEST(Phases, repeated_steps_give_the_same_bits) {
  Json json = soil_behind_a_gate();
  json["phases"] = {{{"until", 1.0}, {"analysis", "quasi_static"}},
                    {{"walls", {wall("bottom", "slip"), wall("left", "slip")}}}};
  const auto once = mpm_solver<2>(json), again = mpm_solver<2>(json);
  InterfaceValues sent;
  for (const StepRequest& request :
       {StepRequest{1, 0, 0, 1.0}, StepRequest{2, 0, 1.0, 0.01}, StepRequest{3, 0, 1.01, 0.01}}) {
    once->solve_step(request, {}, sent);
    once->accept_step(request, true);
    StepRequest longer = request;
    longer.dt *= 0.5;
    again->solve_step(longer, {}, sent);
    again->reject_step();
    again->solve_step(request, {}, sent);
    again->accept_step(request, true);
  }
  EXPECT_TRUE(same_bits(once->points(), again->points()));
  EXPECT_GT(probe(*once, "momentum_x"), 1e-3);
}

}  // namespace
}  // namespace gabion::test::test_phases
