// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "common/run/repeated_failure.hpp"
#include "tests/support/expect_error.hpp"

namespace gabion::test {
namespace {

const ConvergenceError same("Newton, iteration 2: stuck; |r|/scale: 1.00e+00 2.00e+00", "line");

TEST(RepeatedFailure, the_same_text_with_another_dt) {
  RepeatedFailure failures;
  EXPECT_EQ(failures.judge({1, 0, 0, 0.5}, same, "ramp").cause(), "line");
  EXPECT_EQ(failures.judge({1, 0, 0, 0.5}, same, "ramp").cause(), "line");  // the same try
  const ConvergenceError error = failures.judge({1, 0, 0, 0.25}, same, "ramp it");
  EXPECT_EQ(error.cause(), fails_at_any_dt);
  EXPECT_EQ(error.exit_code(), 3);
  expect_parts(error.what(), {"dt = 0.5 s and dt = 0.25 s", "ramp it", same.what()});
}

TEST(RepeatedFailure, what_differs_is_another_failure) {
  RepeatedFailure failures;
  const ConvergenceError other("Newton, iteration 2: stuck; |r|/scale: 1.00e+00 1.99e+00");
  const ConvergenceError without_residuals("soil leaves the grid");
  for (const auto& [request, error] : {std::pair(StepRequest{1, 0, 0, 0.5}, same),
                                       {{1, 0, 0, 0.25}, other},
                                       {{2, 0, 0.25, 0.125}, other},
                                       {{2, 0, 0.3, 0.1}, other},
                                       {{2, 0, 0.3, 0.05}, same},
                                       {{2, 0, 0.3, 0.02}, without_residuals},
                                       {{2, 0, 0.3, 0.01}, without_residuals}}) {
    EXPECT_STREQ(failures.judge(request, error, "").what(), error.what());
  }
}

}  // namespace
}  // namespace gabion::test
