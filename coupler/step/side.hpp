// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "common/base/timer.hpp"
#include "common/run/asynchronous_solver.hpp"
#include "coupler/mapping/interface_layout.hpp"

namespace gabion {

/// A participant and its state in the current step. It takes its share of the vectors of
/// its side, and puts its answers in their place.
///
///     begin_step, (begin_solution, solution, ..., reject)*, begin_solution, solution, ...,
///     start_accept, finish_accept
///     solution: start_solve, finish_solve; or skip
class Side {
 public:
  Side(InterfaceLayout layout, Solver& solver) : layout_(std::move(layout)), solver_(solver) {}

  const InterfaceLayout& layout() const { return layout_; }
  const std::string& name() const { return layout_.participant(); }
  Solver& solver() const { return solver_; }

  void begin_step();
  void begin_solution() { linear_iterations_ = 0; }
  /// Begin to solve, and return at once when the solver is in another process.
  /// @param given  values at all interfaces of this side
  void start_solve(const StepRequest& request, const Eigen::VectorXd& given);
  bool is_under_way() const { return under_way_.has_value(); }
  /// @param[in,out] answer  of all interfaces of this side: this participant's share is set
  /// @throws ConvergenceError  the solver could not solve; no request is open then
  void finish_solve(Eigen::VectorXd& answer);
  /// Skip the solver in this iteration.
  void skip();
  /// Begin to accept, and return at once when the solver is in another process.
  void start_accept(const StepRequest& request);
  /// @param given  values at all interfaces of this side in the accepted solution
  /// @param since  the wait for a solver in another process runs from here on
  AcceptReport finish_accept(const Eigen::VectorXd& given, const Stopwatch& since);
  void reject();

  bool takes_next_step() const;
  /// Start the solution of the next step, see start_solve; the solver drops it when it proposes
  /// another step size than these. Call it between start_accept and finish_accept.
  void start_next(const StepRequest& request, const Eigen::VectorXd& given,
                  const DtRange& proposed);
  /// Whether the solver solves the next step; known after finish_accept.
  bool solves_next() const { return solves_next_; }
  /// Call off the solution of the next step; no request is open afterwards.
  void call_off_next();

  const StepReport& report() const { return report_; }  ///< report of the last solution
  bool solved() const { return solved_; }  ///< whether it was solved in the last iteration
  /// Whether the solver was at rest after the last accepted step and was given nothing but zeros.
  bool may_sleep() const { return may_sleep_; }

  /// Add the numbers of the accepted step as "name.number": the solver's own ones,
  /// `linear_iterations` of all iterations of the accepted solution, and where `wall_seconds` of
  /// the step went.
  void add_details(double wall_seconds, Json& details) const;
  /// Calls since the start, by kind; null of a solver in this process.
  Json calls() const;
  void visit_state(StateVisitor& visitor) { visitor.flag("may_sleep." + name(), may_sleep_); }

 private:
  class CallTimer;
  struct UnderWay {
    StepRequest request;  // request for a solver in this process, which solves in finish_solve
    InterfaceValues received;
    Stopwatch watch;
    DtRange proposed = {};  // on which it depends
  };
  AsynchronousSolver* asynchronous() const { return dynamic_cast<AsynchronousSolver*>(&solver_); }
  void note_solution(const StepReport& report);

  InterfaceLayout layout_;
  Solver& solver_;
  StepReport report_;
  bool solved_ = false;
  bool may_sleep_ = false;
  std::optional<UnderWay> under_way_;
  StepRequest accepting_;
  bool solves_next_ = false;
  Json accepted_details_ = Json::object();
  std::int64_t linear_iterations_ = 0;
  double call_seconds_ = 0;  // time waited in all calls since the start of the step, rejected tries
                             // too
  double busy_seconds_ = 0;  // time the solver computed, also while nobody waited
};

}  // namespace gabion
