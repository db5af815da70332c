// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/checks/participant_check.hpp"

#include <fmt/format.h>

#include <functional>
#include <utility>

#include "common/base/error.hpp"
#include "common/run/facets.hpp"
#include "common/run/start.hpp"
#include "coupler/checks/check_table.hpp"
#include "coupler/checks/driven_participant.hpp"

namespace gabion {
namespace {

constexpr int num_rejecting_steps = 5;
constexpr double warm_start_tolerance = 1e-8;  // tolerance by the largest value

/// The trials of a participant, a row each.
class ParticipantCheck {
 public:
  ParticipantCheck(Solver& solver, const CheckSettings& settings)
      : participant_(solver, settings), table_(settings.report), finish_(settings.finish) {
    first_ = participant_.random_values();
    second_ = participant_.random_values();
  }

  std::vector<CheckRow> run() {
    try {
      if (participant_.solver().takes_force_kinds()) {
        table_.expect_done("forces that are means of a step, from here on",
                           [this] { participant_.tell_force_kinds(); });
      }
      if (takes_start(participant_.solver())) {
        table_.expect_done("interfaces that start at their reference places",
                           [this] { participant_.tell_start(); });
      }
      if (takes_facets(participant_.solver())) {
        table_.expect_done("facets that are those it has", [this] { participant_.tell_facets(); });
      }
      table_.expect_done("output at time 0", [this] { participant_.write_output(); });
      try_first_step();
      try_smaller_steps();
      try_other_requests();
      try_accepted_step();
      try_many_steps();
      try_states();
      try_facets();
      try_skipped_step();
      try_details();
      table_.expect_done("summary", [this] { participant_.solver().summary(); });
      if (finish_) table_.expect_done("the end", finish_);
    } catch (const ProtocolError& lost) {
      table_.add({"it stays", CheckRow::Outcome::failed,
                  fmt::format("lost in \"{}\": {}", table_.under_way(), lost.what())});
    }
    return table_.rows();
  }

 private:
  void try_first_step() {
    InterfaceValues answer;
    table_.expect_done("a first step", [&] { answer = participant_.solve(first_); });
    if (answer.empty()) return;
    const auto repeat = [&] { return participant_.again(first_, answer); };
    table_.expect_equal("the same request again", repeat, warm_start_tolerance);
    const auto repeat_after_other = [&] {
      participant_.solve(second_);
      return participant_.again(first_, answer);
    };
    table_.expect_equal("the same request after another trial", repeat_after_other,
                        warm_start_tolerance);
    table_.expect_equal("the same bits after reject_step", [&] {
      participant_.solve(second_);
      participant_.reject();
      return participant_.again(first_, answer);
    });
    table_.expect_equal("the same bits after reject_step twice", [&] {
      participant_.reject();
      participant_.reject();
      return participant_.again(first_, answer);
    });
  }

  void try_smaller_steps() {
    table_.expect_equal("half of dt, rejected: the same bits again", [&] {
      participant_.reject();
      const InterfaceValues answer = participant_.solve(first_, 0.5);
      participant_.reject();
      return participant_.again(first_, answer, 0.5);
    });
    table_.expect_equal("the same bits with dt after trials with dt/2 and dt/4", [&] {
      participant_.reject();
      const InterfaceValues answer = participant_.solve(first_);
      participant_.reject();
      participant_.solve(second_, 0.5);
      participant_.reject();
      participant_.solve(second_, 0.25);
      participant_.reject();
      return participant_.again(first_, answer);
    });
  }

  void try_other_requests() {
    table_.expect_change(
        "other values: another answer",
        [&] {
          participant_.reject();
          const InterfaceValues answer = participant_.solve(first_);
          participant_.reject();
          return participant_.again(second_, answer);
        },
        participant_.last_report().interface_active
            ? "the same bits: right only where these values can not move it"
            : "the same bits: as its report says (interface_active false)");
    table_.expect_change(
        "another dt: another answer",
        [&] {
          participant_.reject();
          const InterfaceValues answer = participant_.solve(first_);
          participant_.reject();
          const AnswerDifference found = participant_.again(first_, answer, 0.5);
          participant_.reject();
          return found;
        },
        "the same bits with dt and dt/2: right only without inertia, damping and rates");
  }

  InterfaceValues accept(const std::string& what, const InterfaceValues& values, double part = 1) {
    InterfaceValues answer;
    table_.expect_done(what, [&] {
      answer = participant_.solve(values, part);
      participant_.accept(part);
    });
    return answer;
  }

  void try_details() {
    table_.judge("details: finite numbers, names as in the first step", [this] {
      const std::string& problem = participant_.details_problem();
      return std::pair(problem.empty() ? CheckRow::Outcome::passed : CheckRow::Outcome::failed,
                       problem);
    });
  }

  void try_accepted_step() {
    const std::int64_t step = participant_.step();
    const InterfaceValues answer = accept("an accepted step", first_);
    if (participant_.step() == step) return;  // it has no solution
    try_second_step();
    table_.expect_change(
        "after it: another answer to the same values",
        [&] {
          participant_.reject();
          return participant_.again(first_, answer);
        },
        fmt::format("the same bits, as if step {} had not been accepted: right only without "
                    "inertia and memory",
                    step));
  }

  void try_second_step() {
    table_.expect_equal("after it: the same bits after reject_step", [&] {
      const InterfaceValues answer = participant_.solve(second_);
      participant_.solve(first_);
      participant_.reject();
      return participant_.again(second_, answer);
    });
    table_.expect_equal("after it: the same bits after output", [&] {
      participant_.reject();
      const InterfaceValues answer = participant_.solve(second_);
      participant_.reject();
      participant_.write_output();
      return participant_.again(second_, answer);
    });
  }

  void try_many_steps() {
    for (int n = 1; n <= num_rejecting_steps; ++n) {
      const InterfaceValues values = participant_.random_values();
      const double part = n % 2 == 0 ? 0.5 : 1;
      table_.expect_equal(
          fmt::format("step {}: the same bits after reject_step", participant_.step()), [&] {
            participant_.reject();
            const InterfaceValues answer = participant_.solve(values, part);
            participant_.solve(first_);
            participant_.reject();
            return participant_.again(values, answer, part);
          });
      accept(fmt::format("step {} accepted", participant_.step()), values, part);
    }
  }

  /// Take some steps, with values that are equal whenever the steps start at the same time.
  /// @returns  the answers
  std::vector<InterfaceValues> steps_from_here() {
    std::vector<InterfaceValues> answers;
    for (const auto& [values, part] :
         {std::pair(&first_, 1.0), std::pair(&second_, 0.5), std::pair(&first_, 0.5)}) {
      answers.push_back(participant_.solve(*values, part));
      participant_.accept(part);
    }
    return answers;
  }

  void try_states() {
    const std::string what = "the same steps after save, other steps and load";
    const std::string rejected = "the same steps from a state saved after reject_step";
    if (participant_.solver().keeps_state()) {
      table_.expect_equal(what, [this] { return try_restart(false); });
      table_.expect_equal(rejected, [this] { return try_restart(true); });
    } else {
      table_.add({what, CheckRow::Outcome::not_asked,
                  "it does not keep its state: a run with it cannot be restarted"});
    }
  }

  /// The facets after the same steps from a state, where facets may change.
  void try_facets() {
    Solver& solver = participant_.solver();
    if (changing_facets(solver).empty() || !solver.keeps_state()) return;
    table_.expect_equal("the same facets after save, steps, load and the same steps", [&] {
      solver.reject_step();
      const State saved = solver.save_state();
      const DrivenParticipant::Place start = participant_.place();
      steps_from_here();
      const std::vector<double> before = participant_.vertices_of_facets();
      participant_.load(saved, start);
      steps_from_here();
      AnswerDifference difference;
      difference.add_list("facets", before, participant_.vertices_of_facets());
      return difference;
    });
  }

  /// Load a state that was saved a while ago, though another one was saved since.
  /// @param after_rejection  the state is saved when a solution has just been rejected
  AnswerDifference try_restart(bool after_rejection) {
    Solver& solver = participant_.solver();
    solver.reject_step();
    const State first = solver.save_state();
    const DrivenParticipant::Place start = participant_.place();
    const std::vector<double> probes = solver.probes();
    const std::vector<InterfaceValues> before = steps_from_here();
    State saved = first;
    if (after_rejection) {
      participant_.load(first, start);
      participant_.solve(second_);
      solver.reject_step();
      saved = solver.save_state();
    } else {
      solver.save_state();
    }
    steps_from_here();
    participant_.load(saved, start);
    AnswerDifference difference;
    difference.add("probes", 1, probes, solver.probes());
    const std::vector<InterfaceValues> after = steps_from_here();
    for (std::size_t n = 0; n < before.size(); ++n) {
      participant_.compare(before[n], after[n], difference);
    }
    return difference;
  }

  void try_skipped_step() {
    const std::string what = "a skipped step";
    if (!participant_.at_rest()) {
      table_.add({what, CheckRow::Outcome::not_asked, "it is not at rest, so it is never skipped"});
      return;
    }
    table_.expect_done(what, [&] {
      participant_.skip_step();
      participant_.solve(first_);
      participant_.reject();
    });
  }

  DrivenParticipant participant_;
  CheckTable table_;
  std::function<void()> finish_;
  InterfaceValues first_, second_;
};

}  // namespace

std::vector<CheckRow> check_participant(Solver& solver, const CheckSettings& settings) {
  return ParticipantCheck(solver, settings).run();
}

}  // namespace gabion
