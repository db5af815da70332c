// SPDX-License-Identifier: BSD-3-Clause
// The check of a participant finds what would spoil a coupled run, and nothing else.
#include <gtest/gtest.h>

#include "common/base/error.hpp"
#include "coupler/participant_check.hpp"

namespace gabion {
namespace {

enum class Habit {
  good,
  keeps_rejected,    ///< goes on from a solution that was rejected
  keeps_trials,      ///< goes on from the last solution, accepted or not
  keeps_after_cuts,  ///< forgets to go back when dt changes
  warm_start,        ///< iterates from the last solution of the step: the same to its tolerance
  never_cold,        ///< the same, and goes on so after reject_step
  fails_below,       ///< no solution with a small dt
  spoilt_by_output,
  dies
};

/// c du/dt = f at every vertex.
class Dashpot : public Solver {
 public:
  explicit Dashpot(Habit habit, bool rests = false) : habit_(habit), rests_(rests) {}

  std::vector<InterfaceMesh> interfaces() const override {
    return {{"wall", 2, {0, 0, 0, 1}, 2, {0, 1}}};
  }
  std::vector<std::string> probe_names() const override { return {}; }
  StepReport solve_step(const StepRequest& request, const InterfaceValues& received,
                        InterfaceValues& sent) override {
    if (habit_ == Habit::dies && ++count_ == 7) throw ProtocolError("it has died");
    if (habit_ == Habit::fails_below && request.dt < 0.1) throw ConvergenceError("dt too small");
    const bool keeps =
        habit_ == Habit::keeps_trials || (habit_ == Habit::keeps_after_cuts && request.dt != dt_);
    if (!keeps) trial_ = start_;
    dt_ = request.dt;
    const std::vector<double>& force = received.at("wall");
    for (std::size_t i = 0; i < 4; ++i) trial_[i] += request.dt * force[i] / 3;
    if (habit_ == Habit::warm_start || habit_ == Habit::never_cold) {
      trial_[0] += 1e-16 * noise_++;
    }
    sent = {{"wall", trial_}};
    return {};
  }
  AcceptReport accept_step(const StepRequest&, bool solved) override {
    if (solved) accepted_ = start_ = trial_;
    noise_ = 0;
    AcceptReport report;
    report.at_rest = rests_;
    return report;
  }
  void reject_step() override {
    if (habit_ != Habit::never_cold) noise_ = 0;
    start_ = habit_ == Habit::keeps_rejected ? trial_ : accepted_;
  }
  void write_output(double) override {
    if (habit_ == Habit::spoilt_by_output && start_[0] != 0) start_[0] += 1;
  }
  std::vector<double> probes() const override { return {}; }
  Json summary() const override { return Json::object(); }

 private:
  Habit habit_;
  bool rests_;
  std::vector<double> accepted_ = std::vector<double>(4, 0.0);
  std::vector<double> start_ = accepted_, trial_ = accepted_;
  double dt_ = 0.1;
  int count_ = 0, noise_ = 0;
};

std::vector<CheckRow> check(Habit habit, bool rests = false) {
  Dashpot solver(habit, rests);
  return check_participant(solver, {0.1, 1e-3});
}

const CheckRow& row(const std::vector<CheckRow>& rows, const std::string& what) {
  for (const CheckRow& candidate : rows) {
    if (candidate.what == what) return candidate;
  }
  throw Error("no row " + what);
}

TEST(ParticipantCheck, a_good_one_passes_every_trial) {
  for (const bool rests : {false, true}) {
    const auto rows = check(Habit::good, rests);
    EXPECT_TRUE(all_passed(rows)) << table_text(rows);
    EXPECT_GT(rows.size(), 20u);
    EXPECT_EQ(row(rows, "a skipped step").verdict,
              rests ? CheckRow::Verdict::passed : CheckRow::Verdict::not_asked);
  }
}

TEST(ParticipantCheck, bad_habits_are_found) {
  const std::vector<std::pair<Habit, std::string>> cases = {
      {Habit::keeps_rejected, "the same bits after reject_step"},
      {Habit::keeps_trials, "the same request again"},
      {Habit::keeps_after_cuts, "half of dt, rejected: the same bits again"},
      {Habit::never_cold, "the same bits after reject_step"},
      {Habit::fails_below, "half of dt, rejected: the same bits again"},
      {Habit::spoilt_by_output, "after it: the same bits after output"},
      {Habit::dies, "it stays"}};
  for (const auto& [habit, what] : cases) {
    const auto rows = check(habit);
    EXPECT_FALSE(all_passed(rows));
    EXPECT_EQ(row(rows, what).verdict, CheckRow::Verdict::failed) << table_text(rows);
  }
  EXPECT_EQ(row(check(Habit::keeps_rejected), "the same request again").verdict,
            CheckRow::Verdict::passed);
}

TEST(ParticipantCheck, a_warm_start_within_the_step_is_told_and_allowed) {
  const auto rows = check(Habit::warm_start);
  EXPECT_TRUE(all_passed(rows)) << table_text(rows);
  EXPECT_EQ(row(rows, "the same request again").verdict, CheckRow::Verdict::inexact);
  EXPECT_EQ(row(rows, "the same bits after reject_step").verdict, CheckRow::Verdict::passed);
}

TEST(ParticipantCheck, the_table_says_where_and_by_how_much) {
  const std::string text = table_text(check(Habit::keeps_trials));
  EXPECT_NE(text.find("FAILED     differs by "), std::string::npos) << text;
  EXPECT_NE(text.find("at \"wall\", vertex "), std::string::npos) << text;
}

}  // namespace
}  // namespace gabion
