// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "common/base/unbalanced.hpp"
#include "common/run/repeated_failure.hpp"
#include "tests/support/expect_error.hpp"

namespace gabion::test::test_repeated_failure {
namespace {

UnbalancedError stuck(std::vector<double> residuals, const std::string& cause = "line") {
  return {"Newton is stuck", cause, std::move(residuals)};
}

const UnbalancedError same = stuck({1, 2e-3});

TEST(RepeatedFailure, the_same_residuals_with_another_dt) {
  RepeatedFailure failures;
  EXPECT_EQ(failures.judge({1, 0, 0, 0.5}, same, "ramp").cause(), "line");
  EXPECT_EQ(failures.judge({1, 0, 0, 0.5}, same, "ramp").cause(), "line");  // the same try
  const ConvergenceError error =
      failures.judge({1, 0, 0, 0.25}, stuck({1.0004, 2.0008e-3}), "ramp it");
  EXPECT_EQ(error.cause(), fails_at_any_dt);
  EXPECT_EQ(error.exit_code(), 3);
  expect_parts(error.what(), {"dt = 0.5 s and dt = 0.25 s", "ramp it", same.what()});
}

TEST(RepeatedFailure, what_differs_is_another_failure) {
  RepeatedFailure failures;
  const auto expect_another = [&](const StepRequest& request, const ConvergenceError& error) {
    EXPECT_STREQ(failures.judge(request, error, "").what(), error.what())
        << request.step << " " << request.time << " " << request.dt;
  };
  expect_another({1, 0, 0, 0.5}, same);
  expect_another({1, 0, 0, 0.25}, stuck({1, 1.99e-3}));  // another residual
  expect_another({1, 0, 0, 0.12}, stuck({1}));           // one iterate less
  expect_another({1, 0, 0, 0.06}, stuck({1, 2e-3}));
  expect_another({1, 0, 0, 0.03}, stuck({1, 2e-3}, "iteration_limit"));
  expect_another({2, 0, 0.25, 0.03}, stuck({1, 2e-3}, "iteration_limit"));
  expect_another({2, 0, 0.3, 0.1}, stuck({1, 2e-3}, "iteration_limit"));
  expect_another({2, 0, 0.3, 0.05}, ConvergenceError("soil leaves the grid", "iteration_limit"));
  expect_another({2, 0, 0.3, 0.02}, ConvergenceError("soil leaves the grid", "iteration_limit"));
  expect_another({2, 0, 0.3, 0.01}, stuck({}, "iteration_limit"));
  expect_another({2, 0, 0.3, 0.005}, stuck({}, "iteration_limit"));
}

/// Later iterations of the coupling are given what it has learnt, and it forgets that as dt falls.
TEST(RepeatedFailure, only_first_iterations_of_the_coupling_count) {
  RepeatedFailure failures;
  EXPECT_EQ(failures.judge({1, 3, 0, 0.5}, same, "").cause(), "line");
  EXPECT_EQ(failures.judge({1, 3, 0, 0.25}, same, "").cause(), "line");
  EXPECT_EQ(failures.judge({1, 0, 0, 0.12}, same, "").cause(), "line");
  EXPECT_EQ(failures.judge({1, 0, 0, 0.06}, same, "").cause(), fails_at_any_dt);
}

}  // namespace
}  // namespace gabion::test::test_repeated_failure
