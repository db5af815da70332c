// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "common/base/timer.hpp"
#include "common/run/solver.hpp"

namespace gabion {

/// A participant and what became of it in the step under way.
///
///     begin_step, (begin_solution, solve or skip, ..., reject)*, begin_solution, solve or skip,
///     ..., accept
class Side {
 public:
  Side(std::string name, Solver& solver) : name_(std::move(name)), solver_(solver) {}

  const std::string& name() const { return name_; }
  Solver& solver() const { return solver_; }

  void begin_step();
  void begin_solution() { linear_iterations_ = 0; }
  void solve(const StepRequest& request, const InterfaceValues& received, InterfaceValues& sent);
  /// Begin to solve, and return at once when the solver is in another process.
  void start_solve(const StepRequest& request, const InterfaceValues& received);
  /// @throws ConvergenceError  the solver could not solve
  void finish_solve(InterfaceValues& sent);
  /// The solver is not asked in this iteration.
  void skip();
  AcceptReport accept(const StepRequest& request);
  void reject();

  const StepReport& report() const { return report_; }  ///< of the last solution
  bool solved() const { return solved_; }               ///< in the last iteration

  /// Add the numbers of the accepted step as "name.number": the solver's own ones,
  /// `linear_iterations` of all iterations of the accepted solution, and where `wall_seconds` of
  /// the step went.
  void add_details(double wall_seconds, Json& details) const;

  bool may_sleep = false;  ///< after the last accepted step: at rest, and no force was on it

 private:
  class CallTimer;
  struct UnderWay {
    StepRequest request;  // of a solver in this process, which solves in finish_solve
    InterfaceValues received;
    Stopwatch watch;
  };
  AsynchronousSolver* asynchronous() const { return dynamic_cast<AsynchronousSolver*>(&solver_); }
  void note_solution(const StepReport& report);

  std::string name_;
  Solver& solver_;
  StepReport report_;
  bool solved_ = false;
  std::optional<UnderWay> under_way_;
  Json accepted_details_ = Json::object();
  std::int64_t linear_iterations_ = 0;
  double call_seconds_ = 0;  // of all calls since the step began, rejected tries too
  double busy_seconds_ = 0;  // of these, as the solver computed
};

}  // namespace gabion
