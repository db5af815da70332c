// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/run/time_steps.hpp"
#include "tests/support/expect_error.hpp"

namespace gabion::test_time_steps {
namespace {

using test::expect_error;

std::vector<double> times_of(TimeSteps& steps) {
  std::vector<double> times = {steps.time()};
  while (!steps.finished()) {
    steps.accept();
    times.push_back(steps.time());
  }
  return times;
}

TEST(TimeSteps, times_are_multiples_of_dt_to_the_bit) {
  TimeSteps steps({1, 0.1, 1e-3});
  const auto times = times_of(steps);
  ASSERT_EQ(times.size(), 11u);
  for (int n = 0; n < 10; ++n) EXPECT_EQ(times[std::size_t(n)], 0.1 * n);
  EXPECT_EQ(times.back(), 1.0);
  EXPECT_EQ(steps.step(), 11);
}

TEST(TimeSteps, many_steps_do_not_drift) {
  TimeSteps steps({100, 1e-3, 1e-5});
  std::int64_t count = 0;
  while (!steps.finished()) {
    EXPECT_EQ(steps.time(), 1e-3 * double(count));
    steps.accept();
    ++count;
  }
  EXPECT_EQ(count, 100000);
  EXPECT_EQ(steps.time(), 100);
}

TEST(TimeSteps, the_last_step_is_shorter_and_ends_exactly) {
  TimeSteps steps({0.25, 0.1, 0.1});
  steps.accept();
  EXPECT_EQ(steps.dt(), 0.1);
  steps.accept();
  EXPECT_EQ(steps.dt(), 0.25 - 0.2);
  EXPECT_EQ(steps.time() + steps.dt(), 0.25);
  steps.accept();
  EXPECT_TRUE(steps.finished());
  EXPECT_EQ(steps.time(), 0.25);
}

TEST(TimeSteps, an_end_off_the_finest_raster_is_reached_exactly) {
  TimeSteps steps({1.0 / 3, 0.1, 0.01});
  const auto times = times_of(steps);
  EXPECT_EQ(times.size(), 5u);
  EXPECT_EQ(times.back(), 1.0 / 3);
}

TEST(TimeSteps, an_end_shorter_than_one_step_is_one_step) {
  TimeSteps steps({0.03, 0.1, 0.1});
  EXPECT_EQ(steps.dt(), 0.03);
  steps.accept();
  EXPECT_TRUE(steps.finished());
}

TEST(TimeSteps, a_cut_halves_and_growth_returns_to_the_raster) {
  TimeSteps steps({10, 1, 0.1});
  steps.accept();
  steps.cut("");
  EXPECT_EQ(steps.dt(), 0.5);
  steps.cut("");
  EXPECT_EQ(steps.dt(), 0.25);
  EXPECT_EQ(steps.time(), 1);
  EXPECT_EQ(steps.step(), 2);
  EXPECT_EQ(steps.cuts(), 2);
  std::vector<double> dts;
  while (steps.time() < 5) {
    dts.push_back(steps.dt());
    steps.accept();
  }
  const std::vector<double> expected = {0.25, 0.25, 0.25, 0.25, 0.5, 0.5, 0.5, 0.5, 1};
  EXPECT_EQ(dts, expected);
}

TEST(TimeSteps, growth_waits_for_a_multiple_of_the_larger_step) {
  TimeSteps steps({10, 1, 0.1});
  steps.cut("");
  for (int n = 0; n < 3; ++n) steps.accept();
  steps.accept();  // 4 accepted, time 2: may grow
  EXPECT_EQ(steps.dt(), 1);
  steps.cut("");
  steps.accept();  // time 2.5
  steps.cut("");   // to 0.25
  for (int n = 0; n < 4; ++n) steps.accept();
  EXPECT_EQ(steps.time(), 3.5);
  EXPECT_EQ(steps.dt(), 0.5);
  for (int n = 0; n < 4; ++n) steps.accept();
  EXPECT_EQ(steps.time(), 5.5);
  EXPECT_EQ(steps.dt(), 0.5);  // 5.5 is no multiple of 1
  steps.accept();
  EXPECT_EQ(steps.dt(), 1);
}

TEST(TimeSteps, equal_schedules_give_equal_bits_with_and_without_cuts) {
  TimeSteps straight({1, 0.1, 1e-4});
  TimeSteps cut({1, 0.1, 1e-4});
  cut.accept();
  for (int n = 0; n < 5; ++n) cut.cut("");
  std::vector<double> late;
  while (!cut.finished()) {
    cut.accept();
    late.push_back(cut.time());
  }
  for (const double t : times_of(straight)) {
    if (t <= 0.5) continue;
    EXPECT_NE(std::find(late.begin(), late.end(), t), late.end()) << t;
  }
}

TEST(TimeSteps, dt_min_ends_the_run_with_the_reason) {
  TimeSteps steps({1, 0.1, 0.03});
  steps.cut("first");
  EXPECT_EQ(steps.dt(), 0.05);
  expect_error<ConvergenceError>([&] { steps.cut("wall fell"); }, {"wall fell", "dt_min = 0.03"});
  EXPECT_EQ(steps.cuts(), 1);
}

TEST(TimeSteps, cutting_a_shorter_last_step_makes_it_smaller) {
  TimeSteps steps({0.13, 0.1, 0.001});
  steps.accept();
  const double last = steps.dt();
  EXPECT_NEAR(last, 0.03, 1e-15);
  steps.cut("");
  EXPECT_LT(steps.dt(), last);
  EXPECT_EQ(steps.dt(), 0.025);
  const auto times = times_of(steps);
  EXPECT_EQ(times.back(), 0.13);
}

TEST(TimeSteps, a_proposal_bounds_the_next_step) {
  TimeSteps steps({10, 1, 0.1});
  steps.accept(0.3);
  EXPECT_EQ(steps.dt(), 0.25);
  for (int n = 0; n < 8; ++n) steps.accept(0.3);
  EXPECT_EQ(steps.dt(), 0.25);
  for (int n = 0; n < 4; ++n) steps.accept(0.6);
  EXPECT_EQ(steps.dt(), 0.5);
  steps.accept(1e-9);
  EXPECT_EQ(steps.dt(), 0.125);  // the smallest step of the raster
}

/// Growth to dt_max: steps of 2 dt start at multiples of 2 dt, times stay multiples of dt to the
/// bit.
TEST(TimeSteps, steps_grow_up_to_dt_max_on_the_raster) {
  TimeSteps steps({.end = 10, .dt = 0.1, .dt_min = 0.01, .dt_max = 0.5});
  std::vector<double> dts;
  while (!steps.finished()) {
    dts.push_back(steps.dt());
    const double multiple = std::round(steps.time() / 0.1);
    EXPECT_EQ(steps.time(), 0.1 * multiple);
    steps.accept();
  }
  const std::vector<double> start = {0.1, 0.1, 0.1, 0.1, 0.2, 0.2, 0.2, 0.2, 0.4, 0.4};
  ASSERT_GT(dts.size(), start.size());
  for (std::size_t n = 0; n < start.size(); ++n) EXPECT_EQ(dts[n], start[n]);
  EXPECT_EQ(*std::max_element(dts.begin(), dts.end()), 0.4);  // 0.8 would be above dt_max
  EXPECT_EQ(steps.time(), 10);
}

TEST(TimeSteps, a_proposal_holds_growth_beyond_dt) {
  TimeSteps steps({.end = 100, .dt = 1, .dt_min = 0.1, .dt_max = 16});
  for (int n = 0; n < 20; ++n) steps.accept(3.9);
  EXPECT_EQ(steps.dt(), 2);
  for (int n = 0; n < 8; ++n) steps.accept(4);
  EXPECT_EQ(steps.dt(), 4);
  steps.cut("");
  EXPECT_EQ(steps.dt(), 2);
}

TEST(TimeSteps, a_last_step_beyond_dt_is_shortened_to_the_end) {
  TimeSteps steps({.end = 10.5, .dt = 1, .dt_min = 0.5, .dt_max = 4});
  EXPECT_EQ(times_of(steps), (std::vector<double>{0, 1, 2, 3, 4, 6, 8, 10, 10.5}));
}

TEST(TimeSettings, all_keys_are_required_and_checked) {
  const auto read = [](const Json& value) {
    return read_time_settings(ConfigReader(value, "f.json", time_keys()));
  };
  const auto refuses = [&](const Json& value, const std::vector<std::string_view>& parts) {
    expect_error<ConfigError>([&] { read(value); }, parts);
  };
  EXPECT_EQ(read({{"end", 1}, {"dt", 0.1}, {"dt_min", 0.1}}).end, 1);
  refuses({{"dt", 0.1}, {"dt_min", 0.1}}, {"f.json: at /end: missing"});
  refuses({{"end", 1}, {"dt_min", 0.1}}, {"f.json: at /dt: missing"});
  refuses({{"end", 1}, {"dt", 0.1}}, {"f.json: at /dt_min: missing"});
  refuses({{"end", 0}, {"dt", 0.1}, {"dt_min", 0.1}}, {"/end: found 0"});
  refuses({{"end", 1}, {"dt", 0.1}, {"dt_min", 0.2}}, {"/dt_min: found 0.2", "<= dt = 0.1"});
  EXPECT_EQ(read({{"end", 1}, {"dt", 0.1}, {"dt_min", 0.1}, {"dt_max", 0.1}}).dt_max, 0.1);
  refuses({{"end", 1}, {"dt", 0.1}, {"dt_min", 0.1}, {"dt_max", 0.05}},
          {"/dt_max: found 0.05, allowed: a number >= dt = 0.1"});
}

TEST(TimeSteps, proposals_of_a_range_and_no_others_lead_to_the_same_next_step) {
  const std::vector<double> proposals = {0,     0.2,    0.1,  0.0999, 0.05, 0.049, 0.02,
                                         0.025, 0.0126, 1e-2, 5e-3,   2e-3, 1e-4};
  for (const double dt_max : {0.1, 0.4}) {
    TimeSteps steps({4, 0.1, 0.1 / 16, dt_max});
    int k = 0, grown = 0, shrunk = 0;
    while (steps.time() < 3.5) {  // the last steps are cut to the end
      for (const double likely : proposals) {
        const DtRange range = steps.same_next(likely);
        EXPECT_TRUE(range.contains(likely)) << likely;
        for (const double other : proposals) {
          const bool same = steps.after(other).dt() == steps.after(likely).dt();
          EXPECT_EQ(range.contains(other), same) << steps.time() << ' ' << likely << ' ' << other;
        }
      }
      const double dt = steps.dt();
      steps.accept(proposals[static_cast<std::size_t>(k * k + k / 7) % proposals.size()]);
      ++k;
      grown += steps.dt() > dt;
      shrunk += steps.dt() < dt;
    }
    EXPECT_GT(grown, 3);
    EXPECT_GT(shrunk, 3);
  }
}

}  // namespace
}  // namespace gabion::test_time_steps
