// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/channel/attention.hpp"

#include <gtest/gtest.h>

namespace gabion::test_attention {
namespace {

using Seconds = Attention::Seconds;

TEST(Attention, looks_for_what_it_does_not_know) {
  EXPECT_GT(Attention().before("soil solve_step"), Seconds(0));
}

TEST(Attention, sleeps_through_long_waits) {
  Attention attention;
  attention.note("soil solve_step", Seconds(5e-3));
  EXPECT_EQ(attention.before("soil solve_step"), Seconds(0));
  EXPECT_GT(attention.before("soil accept_step"), Seconds(0));
}

TEST(Attention, looks_for_what_comes_soon) {
  Attention attention;
  attention.note("solve_step", Seconds(5e-4));
  EXPECT_GT(attention.before("solve_step"), Seconds(5e-4));
}

TEST(Attention, learns_that_waits_became_short_or_long) {
  Attention attention;
  for (int k = 0; k < 20; ++k) attention.note("solve_step", Seconds(5e-3));
  EXPECT_EQ(attention.before("solve_step"), Seconds(0));
  for (int k = 0; k < 20; ++k) attention.note("solve_step", Seconds(1e-4));
  EXPECT_GT(attention.before("solve_step"), Seconds(0));
  for (int k = 0; k < 20; ++k) attention.note("solve_step", Seconds(5e-3));
  EXPECT_EQ(attention.before("solve_step"), Seconds(0));
}

}  // namespace
}  // namespace gabion::test_attention
