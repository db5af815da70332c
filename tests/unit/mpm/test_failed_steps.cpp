// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <sstream>

#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test::test_failed_steps {
namespace {

/// Soil that a moving wall squeezes against another one, by a quarter of its width in 1 s.
Json squeezed(double push) {
  Json material = elastic_soil("mohr_coulomb", 1e6, 0.3, 1000);
  material["friction_angle"] = 30;
  material["cohesion"] = 1000;
  Json mover = wall("left", "slip");
  mover["motion"] = {{"velocity", {push, 0}}};
  return {{"dimension", 2},
          {"grid", box({0, 0}, {1, 1.5}, {4, 6}, "quad4")},
          {"analysis", "quasi_static"},
          {"walls", {mover, wall("right", "slip"), wall("bottom", "slip")}},
          {"bodies", {body("soil", box({0, 0}, {1, 1}, {4, 4}, "quad4"), 4, material)}},
          {"newton", {{"residual_tolerance", 1e-12}, {"max_iterations", 30}}}};
}

std::string failure_of(Solver& solver, double dt, std::string& cause) {
  InterfaceValues sent;
  try {
    solver.solve_step({1, 0, 0, dt}, {}, sent);
  } catch (const ConvergenceError& error) {
    cause = error.cause();
    return error.what();
  }
  return "no failure";
}

TEST(FailedSteps, name_worst_node_and_worst_point) {
  Json json = squeezed(0.05);
  json["newton"]["max_iterations"] = 1;
  const auto solver = make_mpm(json);
  std::string cause;
  const std::string text = failure_of(*solver, 1, cause);
  EXPECT_EQ(cause, "iteration_limit");
  expect_parts(text,
               {"iteration limit reached", "worst grid node ", "most strained material point ",
                " of \"soil\" at (", "strain increment 0.0", "volume ratio of the step ", "shear"});
}

/// |r| / scale of each iterate, as the message of a failed step lists them.
std::vector<double> residuals_of(const std::string& text) {
  std::istringstream series(text.substr(text.find("|r|/scale: ") + 11));
  return {std::istream_iterator<double>(series), {}};
}

/// 5 % in one step of soil under its weight, most points at yield: once near the solution, e_{k+1}
/// <= C e_k^2.
TEST(FailedSteps, residuals_of_a_plastic_step_fall_quadratically) {
  Json json = squeezed(0.05);
  json["gravity"] = {0, -10};
  std::vector<double> e;
  for (int limit = 1; limit < 20; ++limit) {  // the last failure has the longest series
    json["newton"] = {{"residual_tolerance", 2.3e-16}, {"max_iterations", limit}};
    std::string cause;
    const std::string text = failure_of(*make_mpm(json), 1, cause);
    if (cause != "iteration_limit") break;
    e = residuals_of(text);
  }
  int checked = 0;
  for (std::size_t k = 0; k + 1 < e.size(); ++k) {
    std::printf("%zu: |r|/scale %.1e\n", k, e[k]);
    if (e[k] > 0.05 || e[k] < 1e-7) continue;
    EXPECT_LT(e[k + 1], std::max(0.5 * e[k] * e[k], 1e-13)) << k;
    ++checked;
  }
  EXPECT_GE(checked, 2);
}

/// A point that a step would turn inside out is named, on whichever rank it is.
TEST(FailedSteps, inadmissible_states_name_the_point) {
  Json json = squeezed(0);
  json["analysis"] = "dynamic";
  json["walls"] = {wall("right", "fixed")};
  json["bodies"][0]["velocity"] = {50, 0};
  const auto solver = make_mpm(json);
  std::string cause;
  const std::string text = failure_of(*solver, 0.01, cause);
  EXPECT_EQ(cause, "inadmissible_guess");  // free flight, two cells into the wall
  expect_parts(text, {"material point ", "would be squeezed below 0.1 of its volume"});
}

/// Weight that acts at once in a quasi-static phase is the same at any dt.
TEST(FailedSteps, that_fail_at_any_dt_say_so) {
  Json json = squeezed(0);
  json["gravity"] = {0, -10};
  json["newton"]["max_iterations"] = 1;
  const auto causes = [&](const Json& scene) {
    const auto solver = make_mpm(scene);
    std::vector<std::string> all;
    for (const double dt : {0.5, 0.25}) {
      failure_of(*solver, dt, all.emplace_back());
      solver->reject_step();
    }
    return all;
  };
  const std::vector<std::string> plain = {"iteration_limit", "iteration_limit"};
  EXPECT_EQ(causes(json), (std::vector<std::string>{"iteration_limit", fails_at_any_dt}));
  Json ramp = json;
  ramp["gravity_ramp"] = {{"duration", 1}};
  EXPECT_EQ(causes(ramp), plain);
  json["analysis"] = "dynamic";
  EXPECT_EQ(causes(json), plain);
}

}  // namespace
}  // namespace gabion::test::test_failed_steps
