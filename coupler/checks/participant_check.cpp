// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/checks/participant_check.hpp"

#include <fmt/format.h>

#include <functional>
#include <random>
#include <tuple>
#include <utility>

#include "common/base/error.hpp"
#include "common/run/run_record.hpp"
#include "coupler/checks/answer_difference.hpp"

namespace gabion {
namespace {

constexpr int num_rejecting_steps = 5;
constexpr double warm_start_tolerance = 1e-8;  // of the largest value

/// A participant's trials, a row each.
class ParticipantCheck {
 public:
  ParticipantCheck(Solver& solver, const CheckSettings& settings)
      : solver_(solver), settings_(settings), meshes_(solver.interfaces()) {
    first_ = random_values();
    second_ = random_values();
  }

  std::vector<CheckRow> run() {
    try {
      try_output("output at time 0");
      try_first_step();
      try_smaller_steps();
      try_other_requests();
      try_accepted_step();
      try_many_steps();
      try_states();
      try_skipped_step();
      try_details();
      row("summary", [this] { return solver_.summary(), AnswerDifference(); });
      if (settings_.finish)
        row("the end", [this] { return settings_.finish(), AnswerDifference(); });
    } catch (const ProtocolError& lost) {
      add({"it stays", CheckRow::Outcome::failed,
           fmt::format("lost in \"{}\": {}", under_way_, lost.what())});
    }
    return rows_;
  }

 private:
  InterfaceValues random_values() {
    InterfaceValues values;
    std::uniform_real_distribution<double> spread(-settings_.amplitude, settings_.amplitude);
    for (const InterfaceMesh& mesh : meshes_) {
      std::vector<double>& list = values[mesh.name];
      for (std::size_t i = 0; i < mesh.coordinates.size(); ++i) list.push_back(spread(random_));
    }
    return values;
  }

  void add(const CheckRow& row) {
    rows_.push_back(row);
    if (settings_.report) settings_.report(row);
  }

  /// @param trial  returns the outcome, and why
  void judge(const std::string& what,
             const std::function<std::pair<CheckRow::Outcome, std::string>()>& trial) {
    under_way_ = what;
    try {
      const auto [outcome, found] = trial();
      add({what, outcome, found});
    } catch (const ConvergenceError& problem) {
      add({what, CheckRow::Outcome::failed,
           fmt::format("the step has no solution: {}", problem.what())});
    }
  }

  /// @param trial      returns how two answers that should be equal differ
  /// @param tolerance  up to which they may, by AnswerDifference::relative
  void row(const std::string& what, const std::function<AnswerDifference()>& trial,
           double tolerance = 0) {
    judge(what, [&] {
      const AnswerDifference found = trial();
      const auto outcome = found.text.empty()            ? CheckRow::Outcome::passed
                           : found.relative <= tolerance ? CheckRow::Outcome::inexact
                                                         : CheckRow::Outcome::failed;
      return std::pair(outcome, found.text);
    });
  }

  /// Two answers that are equal in few codes only.
  /// @param trial    returns how they differ
  /// @param meaning  what it means when they do not
  void expect_change(const std::string& what, const std::function<AnswerDifference()>& trial,
                     const std::string& meaning) {
    judge(what, [&] {
      const bool changes = !trial().text.empty();
      return changes ? std::pair(CheckRow::Outcome::passed, std::string())
                     : std::pair(CheckRow::Outcome::notice, meaning);
    });
  }

  StepRequest request(double dt) const { return {step_, 0, time_, dt}; }

  InterfaceValues solve(const InterfaceValues& values, double part_of_dt = 1) {
    InterfaceValues answer;
    last_report_ = solver_.solve_step(request(part_of_dt * settings_.dt), values, answer);
    return answer;
  }

  /// Solve, and compare with an earlier answer to the same.
  AnswerDifference again(const InterfaceValues& values, const InterfaceValues& before,
                         double part_of_dt = 1) {
    AnswerDifference difference;
    compare(before, solve(values, part_of_dt), difference);
    return difference;
  }

  void compare(const InterfaceValues& before, const InterfaceValues& now,
               AnswerDifference& difference) const {
    for (const InterfaceMesh& mesh : meshes_) {
      difference.add(mesh.name, mesh.dim, before.at(mesh.name), now.at(mesh.name));
    }
  }

  void try_output(const std::string& what) {
    row(what, [this] { return solver_.write_output(time_), AnswerDifference(); });
  }

  void try_first_step() {
    InterfaceValues answer;
    row("a first step", [&] { return answer = solve(first_), AnswerDifference(); });
    if (answer.empty()) return;
    const auto repeat = [&] { return again(first_, answer); };
    row("the same request again", repeat, warm_start_tolerance);
    const auto repeat_after_other = [&] {
      solve(second_);
      return again(first_, answer);
    };
    row("the same request after another trial", repeat_after_other, warm_start_tolerance);
    row("the same bits after reject_step", [&] {
      solve(second_);
      solver_.reject_step();
      return again(first_, answer);
    });
    row("the same bits after reject_step twice", [&] {
      solver_.reject_step();
      solver_.reject_step();
      return again(first_, answer);
    });
  }

  void try_smaller_steps() {
    row("half of dt, rejected: the same bits again", [&] {
      solver_.reject_step();
      const InterfaceValues answer = solve(first_, 0.5);
      solver_.reject_step();
      return again(first_, answer, 0.5);
    });
    row("the same bits with dt after trials with dt/2 and dt/4", [&] {
      solver_.reject_step();
      const InterfaceValues answer = solve(first_);
      solver_.reject_step();
      solve(second_, 0.5);
      solver_.reject_step();
      solve(second_, 0.25);
      solver_.reject_step();
      return again(first_, answer);
    });
  }

  void try_other_requests() {
    expect_change(
        "other values: another answer",
        [&] {
          solver_.reject_step();
          const InterfaceValues answer = solve(first_);
          solver_.reject_step();
          return again(second_, answer);
        },
        last_report_.interface_active
            ? "the same bits: right only where these values can not move it"
            : "the same bits: as its report says (interface_active false)");
    expect_change(
        "another dt: another answer",
        [&] {
          solver_.reject_step();
          const InterfaceValues answer = solve(first_);
          solver_.reject_step();
          const AnswerDifference found = again(first_, answer, 0.5);
          solver_.reject_step();
          return found;
        },
        "the same bits with dt and dt/2: right only without inertia, damping and rates");
  }

  InterfaceValues accept(const std::string& what, const InterfaceValues& values,
                         double part_of_dt = 1) {
    InterfaceValues answer;
    row(what, [&] {
      answer = solve(values, part_of_dt);
      accept_last(part_of_dt);
      return AnswerDifference();
    });
    return answer;
  }

  void accept_last(double part_of_dt) {
    const StepRequest accepted = request(part_of_dt * settings_.dt);
    const AcceptReport report = solver_.accept_step(accepted, true);
    at_rest_ = report.at_rest;
    note_details(last_report_.details, report.details);
    time_ += accepted.dt;
    ++step_;
  }

  /// As a run does that writes them into its table of steps.
  void note_details(const Json& of_solution, const Json& of_acceptance) {
    Json details = Json::object();
    for (const Json* report : {&of_solution, &of_acceptance}) {
      for (const auto& item : report->items()) details[item.key()] = item.value();
    }
    if (!details_.started()) details_.start(details);
    try {
      std::vector<CsvValue> cells;
      details_.append(details, cells);
    } catch (const Error& problem) {
      if (details_problem_.empty()) details_problem_ = problem.what();
    }
  }

  void try_details() {
    judge("details: finite numbers, names as in the first step", [this] {
      const auto outcome =
          details_problem_.empty() ? CheckRow::Outcome::passed : CheckRow::Outcome::failed;
      return std::pair(outcome, details_problem_);
    });
  }

  void try_accepted_step() {
    const std::int64_t step = step_;
    const InterfaceValues answer = accept("an accepted step", first_);
    if (step_ == step) return;  // it has no solution
    try_second_step();
    expect_change(
        "after it: another answer to the same values",
        [&] {
          solver_.reject_step();
          return again(first_, answer);
        },
        fmt::format("the same bits, as if step {} had not been accepted: right only without "
                    "inertia and memory",
                    step));
  }

  void try_second_step() {
    row("after it: the same bits after reject_step", [&] {
      const InterfaceValues answer = solve(second_);
      solve(first_);
      solver_.reject_step();
      return again(second_, answer);
    });
    row("after it: the same bits after output", [&] {
      solver_.reject_step();
      const InterfaceValues answer = solve(second_);
      solver_.reject_step();
      solver_.write_output(time_);
      return again(second_, answer);
    });
  }

  void try_many_steps() {
    for (int n = 1; n <= num_rejecting_steps; ++n) {
      const InterfaceValues values = random_values();
      const double part = n % 2 == 0 ? 0.5 : 1;
      row(fmt::format("step {}: the same bits after reject_step", step_), [&] {
        solver_.reject_step();
        const InterfaceValues answer = solve(values, part);
        solve(first_);
        solver_.reject_step();
        return again(values, answer, part);
      });
      accept(fmt::format("step {} accepted", step_), values, part);
    }
  }

  /// Some steps with the same values each time they are called at the same time.
  /// @returns  the answers
  std::vector<InterfaceValues> steps_from_here() {
    std::vector<InterfaceValues> answers;
    for (const auto& [values, part] :
         {std::pair(&first_, 1.0), std::pair(&second_, 0.5), std::pair(&first_, 0.5)}) {
      answers.push_back(solve(*values, part));
      accept_last(part);
    }
    return answers;
  }

  void try_states() {
    const std::string what = "the same steps after save, other steps and load";
    const std::string rejected = "the same steps from a state saved after reject_step";
    if (solver_.keeps_state()) {
      row(what, [this] { return try_restart(false); });
      row(rejected, [this] { return try_restart(true); });
    } else {
      add({what, CheckRow::Outcome::not_asked,
           "it does not keep its state: a run with it cannot be restarted"});
    }
  }

  /// A state that was saved a while ago comes back, though another one was saved since.
  /// @param after_rejection  the state is saved when a solution has just been rejected
  AnswerDifference try_restart(bool after_rejection) {
    solver_.reject_step();
    const State first = solver_.save_state();
    const auto start = std::pair(step_, time_);
    const std::vector<double> probes = solver_.probes();
    const std::vector<InterfaceValues> before = steps_from_here();
    State saved = first;
    if (after_rejection) {
      solver_.load_state(first);
      std::tie(step_, time_) = start;
      solve(second_);
      solver_.reject_step();
      saved = solver_.save_state();
      steps_from_here();
    } else {
      solver_.save_state();
      steps_from_here();
    }
    solver_.load_state(saved);
    std::tie(step_, time_) = start;
    AnswerDifference difference;
    difference.add("probes", 1, probes, solver_.probes());
    const std::vector<InterfaceValues> after = steps_from_here();
    for (std::size_t n = 0; n < before.size(); ++n) compare(before[n], after[n], difference);
    return difference;
  }

  void try_skipped_step() {
    const std::string what = "a skipped step";
    if (!at_rest_) {
      add({what, CheckRow::Outcome::not_asked, "it is not at rest, so it is never skipped"});
      return;
    }
    row(what, [&] {
      solver_.accept_step(request(settings_.dt), false);
      time_ += settings_.dt;
      ++step_;
      solve(first_);
      solver_.reject_step();
      return AnswerDifference();
    });
  }

  Solver& solver_;
  CheckSettings settings_;
  std::vector<InterfaceMesh> meshes_;
  std::mt19937_64 random_{1};
  InterfaceValues first_, second_;
  std::vector<CheckRow> rows_;
  std::string under_way_;  // the check that the next row will tell of
  StepReport last_report_;
  DetailColumns details_;
  std::string details_problem_;
  std::int64_t step_ = 1;
  double time_ = 0;
  bool at_rest_ = false;
};

}  // namespace

std::vector<CheckRow> check_participant(Solver& solver, const CheckSettings& settings) {
  return ParticipantCheck(solver, settings).run();
}

}  // namespace gabion
