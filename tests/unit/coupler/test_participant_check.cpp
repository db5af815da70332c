// SPDX-License-Identifier: BSD-3-Clause
// The check of a participant finds what would spoil a coupled run, and nothing else.
#include <gtest/gtest.h>

#include "common/base/error.hpp"
#include "common/run/facets.hpp"
#include "coupler/checks/participant_check.hpp"

namespace gabion::test_participant_check {
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
  forgets_load,      ///< loading does nothing
  keeps_last_save,   ///< goes back to what it saved last, whatever it is given
  saves_too_little,  ///< lacks a part of the state
  spoils_probes,     ///< its probes do not come back
  saves_trial,       ///< saves the last solution, accepted or not
  forgets_accept,    ///< always solves from the initial state
  ignores_values,    ///< the answer depends on dt only
  ignores_dt,        ///< the answer depends on the values only
  new_detail,        ///< reports a number that the first step did not
  text_detail,       ///< reports a text
  keeps_no_state,
  good_with_kinds,  ///< takes forces that are means of a step
  moves_old_force,  ///< the force of the step before is that of the last solution
  loses_old_force,  ///< the state lacks the force of the step before
  dies
};

bool asks_for_kinds(Habit habit) {
  return habit == Habit::moves_old_force || habit == Habit::loses_old_force ||
         habit == Habit::good_with_kinds;
}

/// c du/dt = f at every vertex, f at the end of the step. Of a mean force F it is 2 F - F_o.
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
    const double dt = habit_ == Habit::ignores_dt ? 1 : request.dt;
    for (std::size_t i = 0; i < 4; ++i) {
      const double at_end = means_ ? 2 * force[i] - old_force_[i] : force[i];
      trial_[i] += dt * (habit_ == Habit::ignores_values ? 1 : at_end) / 3;
    }
    force_ = force;
    if (habit_ == Habit::moves_old_force) old_force_ = force;
    if (habit_ == Habit::warm_start || habit_ == Habit::never_cold) {
      trial_[0] += 1e-16 * noise_++;
    }
    sent = {{"wall", trial_}};
    return {};
  }
  AcceptReport accept_step(const StepRequest& request, bool solved) override {
    if (solved && habit_ != Habit::forgets_accept) {
      accepted_ = start_ = trial_;
      if (means_) old_force_ = force_;
    }
    probe_ = accepted_[0];
    noise_ = 0;
    AcceptReport report;
    report.at_rest = rests_;
    report.details["energy"] = 0.5;
    if (habit_ == Habit::new_detail && request.step > 2) report.details["late"] = 1;
    if (habit_ == Habit::text_detail) report.details["energy"] = "much";
    return report;
  }
  void reject_step() override {
    if (habit_ != Habit::never_cold) noise_ = 0;
    start_ = habit_ == Habit::keeps_rejected ? trial_ : accepted_;
  }
  void write_output(double) override {
    if (habit_ == Habit::spoilt_by_output && start_[0] != 0) start_[0] += 1;
  }
  std::vector<double> probes() const override { return {probe_}; }
  bool takes_force_kinds() const override { return asks_for_kinds(habit_); }
  void set_force_kinds(const ForceKinds& kinds) override {
    means_ = kinds.at("wall") == ForceKind::step_mean;
  }
  bool keeps_state() const override { return habit_ != Habit::keeps_no_state; }
  State save_state() override {
    State state;
    state.reals["u"] = last_save_ = habit_ == Habit::saves_trial ? trial_ : accepted_;
    if (habit_ == Habit::saves_too_little) state.reals["u"][3] = 0;
    if (habit_ != Habit::loses_old_force) state.reals["old_force"] = old_force_;
    return state;
  }
  void load_state(const State& state) override {
    if (habit_ == Habit::forgets_load) return;
    accepted_ = habit_ == Habit::keeps_last_save ? last_save_ : state.reals.at("u");
    start_ = trial_ = accepted_;
    if (state.reals.contains("old_force")) old_force_ = state.reals.at("old_force");
    if (habit_ != Habit::spoils_probes) probe_ = accepted_[0];
  }
  Json summary() const override { return Json::object(); }

 private:
  Habit habit_;
  bool rests_;
  std::vector<double> accepted_ = std::vector<double>(4, 0.0);
  std::vector<double> start_ = accepted_, trial_ = accepted_, last_save_;
  std::vector<double> force_ = accepted_, old_force_ = accepted_;
  bool means_ = false;
  double probe_ = 0;
  double dt_ = 0.1;
  int count_ = 0, noise_ = 0;
};

const std::string restart = "the same steps after save, other steps and load";
const std::string rejected_save = "the same steps from a state saved after reject_step";
const std::string details = "details: finite numbers, names as in the first step";

std::vector<CheckRow> check(Habit habit, bool rests = false) {
  Dashpot solver(habit, rests);
  return check_participant(solver, {.dt = 0.1, .amplitude = 1e-3});
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
    EXPECT_EQ(row(rows, restart).outcome, CheckRow::Outcome::passed);
    EXPECT_EQ(row(rows, "a skipped step").outcome,
              rests ? CheckRow::Outcome::passed : CheckRow::Outcome::not_asked);
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
      {Habit::forgets_load, restart},
      {Habit::keeps_last_save, restart},
      {Habit::saves_too_little, restart},
      {Habit::spoils_probes, restart},
      {Habit::saves_trial, rejected_save},
      {Habit::new_detail, details},
      {Habit::text_detail, details},
      {Habit::moves_old_force, "the same request again"},
      {Habit::loses_old_force, restart},
      {Habit::dies, "it stays"}};
  for (const auto& [habit, what] : cases) {
    const auto rows = check(habit);
    EXPECT_FALSE(all_passed(rows));
    EXPECT_EQ(row(rows, what).outcome, CheckRow::Outcome::failed) << table_text(rows);
  }
  EXPECT_EQ(row(check(Habit::keeps_rejected), "the same request again").outcome,
            CheckRow::Outcome::passed);
}

TEST(ParticipantCheck, a_structure_that_asks_for_kinds_of_force_gets_means) {
  const auto rows = check(Habit::good_with_kinds);
  EXPECT_TRUE(all_passed(rows)) << table_text(rows);
  EXPECT_EQ(rows.front().what, "forces that are means of a step, from here on");
  EXPECT_EQ(row(check(Habit::loses_old_force), "the same request again").outcome,
            CheckRow::Outcome::passed);
}

TEST(ParticipantCheck, what_few_codes_may_do_is_a_notice) {
  const std::vector<std::pair<Habit, std::string>> cases = {
      {Habit::forgets_accept, "after it: another answer to the same values"},
      {Habit::ignores_values, "other values: another answer"},
      {Habit::ignores_dt, "another dt: another answer"}};
  for (const auto& [habit, what] : cases) {
    const auto rows = check(habit);
    EXPECT_TRUE(all_passed(rows)) << table_text(rows);
    for (const auto& [other, row_of_other] : cases) {
      EXPECT_EQ(row(rows, row_of_other).outcome,
                other == habit ? CheckRow::Outcome::notice : CheckRow::Outcome::passed)
          << table_text(rows);
    }
  }
  const std::string text = table_text(check(Habit::forgets_accept));
  EXPECT_NE(text.find("NOTICE     the same bits, as if step 1 had not been accepted"),
            std::string::npos)
      << text;
}

TEST(ParticipantCheck, a_state_of_a_rejected_solution_is_found_by_its_own_row) {
  EXPECT_EQ(row(check(Habit::saves_trial), restart).outcome, CheckRow::Outcome::passed);
  EXPECT_NE(row(check(Habit::new_detail), details).found.find("\"late\""), std::string::npos);
}

/// Its facet leaves in every other step, and comes back.
class Flickering : public Dashpot, public ChangesFacets {
 public:
  explicit Flickering(bool forgets) : Dashpot(Habit::good), forgets_(forgets) {}
  InterfaceFacets facets() const override {
    return {
        {"wall", count_ % 2 == 0 ? std::vector<std::int64_t>{0, 1} : std::vector<std::int64_t>()}};
  }
  AcceptReport accept_step(const StepRequest& request, bool solved) override {
    ++count_;
    return Dashpot::accept_step(request, solved);
  }
  State save_state() override {
    State state = Dashpot::save_state();
    state.reals["count"] = {static_cast<double>(count_)};
    return state;
  }
  void load_state(const State& state) override {
    Dashpot::load_state(state);
    if (!forgets_) count_ = static_cast<int>(state.reals.at("count").front());
  }

 private:
  bool forgets_;
  int count_ = 0;
};

TEST(ParticipantCheck, facets_that_a_state_lacks_are_found) {
  const std::string what = "the same facets after save, steps, load and the same steps";
  for (const bool forgets : {false, true}) {
    Flickering solver(forgets);
    const auto rows = check_participant(solver, {.dt = 0.1, .amplitude = 1e-3});
    EXPECT_EQ(all_passed(rows), !forgets) << table_text(rows);
    EXPECT_EQ(row(rows, what).outcome,
              forgets ? CheckRow::Outcome::failed : CheckRow::Outcome::passed);
  }
}

/// A soil, for this purpose, that takes other facets.
class Open : public Dashpot, public TakesFacets {
 public:
  Open() : Dashpot(Habit::good) {}
  void set_facets(const InterfaceFacets& facets) override { told = facets; }
  InterfaceFacets told;
};

TEST(ParticipantCheck, one_that_takes_other_facets_gets_its_own) {
  Open solver;
  const auto rows = check_participant(solver, {.dt = 0.1, .amplitude = 1e-3});
  EXPECT_TRUE(all_passed(rows)) << table_text(rows);
  EXPECT_EQ(rows.front().what, "facets that are those it has");
  EXPECT_EQ(solver.told, (InterfaceFacets{{"wall", {0, 1}}}));
}

TEST(ParticipantCheck, rows_are_told_when_they_are_known) {
  Dashpot solver(Habit::dies);
  std::vector<std::string> told;
  bool finished = false;
  const auto rows =
      check_participant(solver, {.dt = 0.1,
                                 .amplitude = 1e-3,
                                 .report = [&](const CheckRow& row) { told.push_back(row.what); },
                                 .finish = [&] { finished = true; }});
  ASSERT_EQ(told.size(), rows.size());
  EXPECT_EQ(told.front(), "output at time 0");
  EXPECT_EQ(told.back(), "it stays");
  EXPECT_FALSE(finished);
  EXPECT_EQ(rows.back().found, "lost in \"the same bits after reject_step twice\": it has died");
}

TEST(ParticipantCheck, the_end_is_the_last_row) {
  Dashpot solver(Habit::good);
  const auto rows =
      check_participant(solver, {.dt = 0.1, .amplitude = 1e-3, .report = {}, .finish = [] {
                                   throw ProtocolError("it does not end");
                                 }});
  EXPECT_EQ(rows.back().outcome, CheckRow::Outcome::failed);
  EXPECT_EQ(rows.back().found, "lost in \"the end\": it does not end");
}

TEST(ParticipantCheck, one_that_keeps_no_state_is_told) {
  const auto rows = check(Habit::keeps_no_state);
  EXPECT_TRUE(all_passed(rows)) << table_text(rows);
  EXPECT_EQ(row(rows, restart).outcome, CheckRow::Outcome::not_asked);
  const std::string found = row(check(Habit::spoils_probes), restart).found;
  EXPECT_NE(found.find("at \"probes\", vertex 0"), std::string::npos) << found;
}

TEST(ParticipantCheck, a_warm_start_within_the_step_is_told_and_allowed) {
  const auto rows = check(Habit::warm_start);
  EXPECT_TRUE(all_passed(rows)) << table_text(rows);
  EXPECT_EQ(row(rows, "the same request again").outcome, CheckRow::Outcome::inexact);
  EXPECT_EQ(row(rows, "the same bits after reject_step").outcome, CheckRow::Outcome::passed);
}

TEST(ParticipantCheck, the_table_says_where_and_by_how_much) {
  const std::string text = table_text(check(Habit::keeps_trials));
  EXPECT_NE(text.find("FAILED     differs by "), std::string::npos) << text;
  EXPECT_NE(text.find("at \"wall\", vertex "), std::string::npos) << text;
}

}  // namespace
}  // namespace gabion::test_participant_check
