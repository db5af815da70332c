// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/run/list_lengths.hpp"
#include "common/run/state.hpp"
#include "common/run/time_steps.hpp"
#include "tests/support/expect_error.hpp"

namespace gabion::test_state {
namespace {

TimeSteps loaded(TimeSteps& from, const TimeSettings& settings) {
  State state;
  StateWriter writer(state);
  from.visit_state(writer);
  TimeSteps steps(settings);
  StateReader reader(state);
  steps.visit_state(reader);
  return steps;
}

TEST(State, gives_every_part_back) {
  State state;
  StateWriter writer(state, "a.");
  std::vector<double> reals = {-0.0, 1.0 / 3, std::numeric_limits<double>::infinity()};
  std::vector<std::int32_t> cells = {-1, 7};
  std::vector<std::int64_t> list = {1, 2, 3};
  Json fact = {{"method", "none"}};
  bool flag = true;
  writer.reals("reals", reals);
  writer.integers("cells", cells);
  writer.list("list", list);
  writer.fact("fact", fact);
  writer.flag("flag", flag);

  StateReader reader(state, "a.");
  std::vector<double> reals_back(3);
  std::vector<std::int32_t> cells_back(2);
  std::vector<std::int64_t> list_back;
  Json fact_back;
  bool flag_back = false;
  reader.reals("reals", reals_back);
  reader.integers("cells", cells_back);
  reader.list("list", list_back);
  reader.fact("fact", fact_back);
  reader.flag("flag", flag_back);
  EXPECT_EQ(reals_back, reals);
  EXPECT_TRUE(std::signbit(reals_back[0]));
  EXPECT_EQ(cells_back, cells);
  EXPECT_EQ(list_back, list);
  EXPECT_EQ(fact_back, fact);
  EXPECT_TRUE(flag_back);
}

TEST(State, lists_and_shares_of_the_own_states_are_joined) {
  std::vector<State> states(2);
  for (int rank = 0; rank < 2; ++rank) {
    StateWriter writer(states[rank]);
    std::vector<std::int64_t> list(rank + 1, 10 * rank);
    std::vector<double> values = {1.5 + rank};
    double equal = 7, share = 1 + rank;
    writer.list("list", list);
    writer.list("values", values);
    writer.real("equal", equal);
    writer.share("share", share);
  }
  EXPECT_EQ(states[0].lists, (std::set<std::string>{"list", "values"}));
  for (const bool gets_all : {true, false}) {
    StateJoiner joiner(states[0], std::span(states).first(gets_all ? 2 : 0));
    std::vector<std::int64_t> list = {99};
    std::vector<double> values;
    double equal = 0, share = 99;
    joiner.list("list", list);
    joiner.list("values", values);
    joiner.real("equal", equal);
    joiner.share("share", share);
    EXPECT_EQ(list,
              gets_all ? (std::vector<std::int64_t>{0, 10, 10}) : std::vector<std::int64_t>());
    EXPECT_EQ(values, gets_all ? (std::vector<double>{1.5, 2.5}) : std::vector<double>());
    EXPECT_EQ(equal, 7);
    EXPECT_EQ(share, gets_all ? 3 : 0);
  }
}

TEST(State, missing_parts_and_other_sizes_are_errors) {
  State state;
  StateWriter writer(state);
  std::vector<double> two = {1, 2}, three(3);
  writer.reals("v", two);
  StateReader reader(state);
  Json fact;
  using test::expect_error;
  expect_error<Error>([&] { reader.reals("v", three); }, {"\"v\" has 2 values, expected 3"});
  expect_error<Error>([&] { reader.reals("w", two); }, {"\"w\" is missing"});
  expect_error<Error>([&] { reader.list("w", two); }, {"\"w\" is missing"});
  expect_error<Error>([&] { reader.fact("v", fact); }, {"\"v\" is missing"});
}

TEST(State, time_steps_go_on_as_if_nothing_had_been) {
  const TimeSettings settings{.end = 0.1, .dt = 1e-3, .dt_min = 1e-6};
  for (int saved_after = 0; saved_after < 12; ++saved_after) {
    TimeSteps straight(settings);
    for (int k = 0; k < saved_after; ++k) {
      if (k == 3) straight.cut("too hard");
      straight.accept(k == 7 ? 3e-4 : 0);
    }
    TimeSteps second = loaded(straight, settings);
    for (int k = 0; k < 30; ++k) {
      ASSERT_EQ(second.time(), straight.time());
      ASSERT_EQ(second.dt(), straight.dt());
      ASSERT_EQ(second.step(), straight.step());
      straight.accept();
      second.accept();
    }
    EXPECT_EQ(second.cuts(), 0);
  }
}

TEST(State, a_finished_run_is_extended) {
  TimeSettings settings{.end = 0.0025, .dt = 1e-3, .dt_min = 1e-3};
  TimeSteps first(settings);
  while (!first.finished()) first.accept();
  EXPECT_EQ(first.time(), 0.0025);  // off the raster of dt_min
  EXPECT_TRUE(loaded(first, settings).finished());
  settings.end = 0.005;
  TimeSteps second = loaded(first, settings);
  EXPECT_FALSE(second.finished());
  EXPECT_EQ(second.time(), 0.0025);
  EXPECT_EQ(second.step(), 4);
  second.accept();
  EXPECT_EQ(second.time(), 0.0025 + 1e-3);
  TimeSteps third = loaded(second, settings);
  EXPECT_EQ(third.time(), second.time());
  while (!third.finished()) third.accept();
  EXPECT_EQ(third.time(), 0.005);
}

TEST(State, numbers_that_do_not_fit_are_refused) {
  State state;
  state.integers["count"] = {std::int64_t{1} << 40};
  state.integers["cells"] = {0, -(std::int64_t{1} << 31) - 1};
  StateReader reader(state);
  int count = 0;
  std::vector<std::int32_t> cells(2);
  test::expect_error<Error>([&] { reader.integer("count", count); },
                            {"\"count\" is 1099511627776"});
  test::expect_error<Error>([&] { reader.integers("cells", cells); }, {"\"cells\" is -2147483649"});
  test::expect_error<Error>([] { require_values_each("x", 7, 3, 2); },
                            {"\"x\" has 7 values for 3"});
  require_values_each("x", 6, 3, 2);
}

TEST(State, a_run_does_not_go_on_from_nowhere) {
  TimeSteps steps({1, 0.1, 1e-3});
  State good;
  StateWriter writer(good);
  steps.visit_state(writer);
  const auto refused = [&](const std::string& name, std::int64_t value) {
    State state = good;
    state.integers.at(name) = {value};
    StateReader reader(state);
    TimeSteps other({1, 0.1, 1e-3});
    test::expect_error<Error>([&] { other.visit_state(reader); }, {"\"" + name + "\" is "});
  };
  refused("level", -100);
  refused("level", 7);
  refused("ticks", -5);
  refused("step", 0);
  refused("accepted_at_level", -1);
  State state = good;
  state.reals.at("time") = {std::nan("")};
  StateReader reader(state);
  test::expect_error<Error>([&] { steps.visit_state(reader); }, {"found time nan"});
}

}  // namespace
}  // namespace gabion::test_state
