// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/participant_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <random>
#include <span>

#include "common/base/error.hpp"

namespace gabion {
namespace {

constexpr int num_rejecting_steps = 5;
constexpr double warm_start_tolerance = 1e-8;  // of the largest value

/// How two answers to the same request compare.
struct Difference {
  std::string text;     ///< empty: the bits are equal; else where they differ most
  double relative = 0;  ///< largest difference by the largest value

  void add(const InterfaceMesh& mesh, std::span<const double> a, std::span<const double> b) {
    const auto dim = static_cast<std::size_t>(mesh.dim);
    for (std::size_t i = 0; i < a.size(); ++i) {
      largest_value_ = std::max({largest_value_, std::abs(a[i]), std::abs(b[i])});
      const double by = std::abs(a[i] - b[i]);
      if (std::memcmp(&a[i], &b[i], sizeof(double)) == 0 || by <= largest_) continue;
      largest_ = by;
      text = fmt::format(
          "differs by {:.3g} ({:.17g}, then {:.17g}) at \"{}\", vertex {}, component {}", by, a[i],
          b[i], mesh.name, i / dim, i % dim);
    }
    relative = largest_ > 0 ? largest_ / largest_value_ : 0;
  }

 private:
  double largest_ = -1;
  double largest_value_ = 0;
};

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
      accept("an accepted step", first_);
      try_second_step();
      try_many_steps();
      try_skipped_step();
      row("summary", [this] { return solver_.summary(), Difference(); });
    } catch (const ProtocolError& lost) {
      rows_.push_back({"it stays", CheckRow::Verdict::failed, lost.what()});
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

  /// @param trial      returns how two answers that should be equal differ
  /// @param tolerance  up to which they may, by Difference::relative
  void row(const std::string& what, const std::function<Difference()>& trial,
           double tolerance = 0) {
    try {
      const Difference found = trial();
      const auto verdict = found.text.empty()            ? CheckRow::Verdict::passed
                           : found.relative <= tolerance ? CheckRow::Verdict::inexact
                                                         : CheckRow::Verdict::failed;
      rows_.push_back({what, verdict, found.text});
    } catch (const ConvergenceError& problem) {
      rows_.push_back({what, CheckRow::Verdict::failed,
                       fmt::format("the step has no solution: {}", problem.what())});
    }
  }

  StepRequest request(double dt) const { return {step_, 0, time_, dt}; }

  InterfaceValues solve(const InterfaceValues& values, double part_of_dt = 1) {
    InterfaceValues answer;
    solver_.solve_step(request(part_of_dt * settings_.dt), values, answer);
    return answer;
  }

  /// Solve, and compare with an earlier answer to the same.
  Difference again(const InterfaceValues& values, const InterfaceValues& before,
                   double part_of_dt = 1) {
    const InterfaceValues now = solve(values, part_of_dt);
    Difference difference;
    for (const InterfaceMesh& mesh : meshes_) {
      difference.add(mesh, before.at(mesh.name), now.at(mesh.name));
    }
    return difference;
  }

  void try_output(const std::string& what) {
    row(what, [this] { return solver_.write_output(time_), Difference(); });
  }

  void try_first_step() {
    InterfaceValues answer;
    row("a first step", [&] { return answer = solve(first_), Difference(); });
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

  void accept(const std::string& what, const InterfaceValues& values, double part_of_dt = 1) {
    row(what, [&] {
      solve(values, part_of_dt);
      const StepRequest accepted = request(part_of_dt * settings_.dt);
      at_rest_ = solver_.accept_step(accepted, true).at_rest;
      time_ += accepted.dt;
      ++step_;
      return Difference();
    });
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

  void try_skipped_step() {
    const std::string what = "a skipped step";
    if (!at_rest_) {
      rows_.push_back(
          {what, CheckRow::Verdict::not_asked, "it is not at rest, so it is never skipped"});
      return;
    }
    row(what, [&] {
      solver_.accept_step(request(settings_.dt), false);
      time_ += settings_.dt;
      ++step_;
      solve(first_);
      solver_.reject_step();
      return Difference();
    });
  }

  Solver& solver_;
  CheckSettings settings_;
  std::vector<InterfaceMesh> meshes_;
  std::mt19937_64 random_{1};
  InterfaceValues first_, second_;
  std::vector<CheckRow> rows_;
  std::int64_t step_ = 1;
  double time_ = 0;
  bool at_rest_ = false;
};

const char* name_of(CheckRow::Verdict verdict) {
  switch (verdict) {
    case CheckRow::Verdict::passed:
      return "passed";
    case CheckRow::Verdict::inexact:
      return "inexact";
    case CheckRow::Verdict::failed:
      return "FAILED";
    case CheckRow::Verdict::not_asked:
      return "not asked";
  }
  return "";
}

}  // namespace

std::vector<CheckRow> check_participant(Solver& solver, const CheckSettings& settings) {
  return ParticipantCheck(solver, settings).run();
}

bool all_passed(const std::vector<CheckRow>& rows) {
  return std::none_of(rows.begin(), rows.end(),
                      [](const CheckRow& row) { return row.verdict == CheckRow::Verdict::failed; });
}

std::string table_text(const std::vector<CheckRow>& rows) {
  std::size_t width = 0;
  for (const CheckRow& row : rows) width = std::max(width, row.what.size());
  std::string text;
  for (const CheckRow& row : rows) {
    const char* verdict = name_of(row.verdict);
    text += fmt::format("{:<{}}  {:<9}{}{}\n", row.what, width, verdict,
                        row.found.empty() ? "" : "  ", row.found);
  }
  return text;
}

}  // namespace gabion
