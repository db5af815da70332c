// SPDX-License-Identifier: BSD-3-Clause
// Steps that do not follow one another are refused.
#include <gtest/gtest.h>

#include "dummy_solver.hpp"
#include "protocol/participant/step_order.hpp"

namespace gabion::test::test_step_order {
namespace {

std::string refusal_of(const std::function<void()>& action) {
  return message_of<ProtocolError>(action);
}

/// Step 1 to 0.1 s and step 2 to 0.15 s are accepted.
StepOrder two_steps() {
  StepOrder order;
  for (const StepRequest& step : {StepRequest{1, 3, 0, 0.1}, StepRequest{2, 0, 0.1, 0.05}}) {
    order.check(step);
    order.solved(step);
    order.accept(step, true);
  }
  return order;
}

TEST(StepOrder, the_next_step_starts_where_the_last_one_ended) {
  const StepOrder order = two_steps();
  order.check({3, 0, 0.1 + 0.05, 0.1});
  order.check({3, 7, 0.15, 0.05});
  EXPECT_EQ(refusal_of([&] {
              order.check({2, 0, 0.15, 0.1});
            }),
            "the coupler asks for step 2 after step 2 was accepted, expected step 3");
  EXPECT_EQ(refusal_of([&] {
              order.check({4, 0, 0.15, 0.1});
            }),
            "the coupler asks for step 4 after step 2 was accepted, expected step 3");
  EXPECT_NE(refusal_of([&] {
              order.check({3, 0, 0.1, 0.1});
            }).find("asks for step 3 from 0.1 s, but the accepted state is that of 0.15"),
            std::string::npos);
}

TEST(StepOrder, round_off_of_long_runs_is_allowed) {
  StepOrder order;
  const StepRequest late{1000, 0, 1e4, 1e-9};
  order.solved(late);
  order.accept(late, true);
  order.check({1001, 0, std::nextafter(1e4 + 1e-9, 2e4), 1e-9});
}

TEST(StepOrder, only_what_was_solved_is_accepted) {
  StepOrder order = two_steps();
  const StepRequest step{3, 0, 0.15, 0.1};
  EXPECT_EQ(refusal_of([&] { order.accept(step, true); }),
            "the coupler accepts step 3, which has no solution");
  order.solved(step);
  EXPECT_TRUE(order.has_solution());
  EXPECT_EQ(refusal_of([&] {
              order.accept({3, 0, 0.15, 0.05}, true);
            }),
            "the coupler accepts step 3 with dt 0.05 s, but the solution is that of step 3 with dt "
            "0.1 s");
  order.reject();
  EXPECT_FALSE(order.has_solution());
  EXPECT_EQ(refusal_of([&] { order.accept(step, true); }),
            "the coupler accepts step 3, which has no solution");
  order.accept(step, false);  // skipped
  order.check({4, 0, 0.25, 0.1});
}

TEST(StepOrder, a_loaded_state_is_of_any_step) {
  StepOrder order = two_steps();
  order.forget();
  order.check({57, 0, 5.6, 0.1});
}

}  // namespace
}  // namespace gabion::test::test_step_order
