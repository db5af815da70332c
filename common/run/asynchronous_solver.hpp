// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "common/run/dt_range.hpp"
#include "common/run/solver.hpp"

namespace gabion {

/// Number and duration of the calls of one kind to a solver in another process.
struct CallTimes {
  std::int64_t count = 0;
  double seconds = 0;       ///< time that the caller waited, messages included
  double busy_seconds = 0;  ///< time that the solver computed, by its own clock
};

/// A solver that computes while its caller does something else, such as one of another process.
class AsynchronousSolver : public Solver {
 public:
  /// Begin solve_step; nothing else may be asked before finish_solve.
  virtual void start_solve(const StepRequest& request, const InterfaceValues& received) = 0;
  /// Wait for the solution. @throws ConvergenceError  as solve_step; no request is open then
  virtual StepReport finish_solve(InterfaceValues& sent) = 0;
  /// Begin accept_step; before finish_accept only start_next may be called.
  virtual void start_accept(const StepRequest& request, bool solved) = 0;
  virtual AcceptReport finish_accept() = 0;

  /// Whether this solver has start_next().
  virtual bool takes_next_step() const { return false; }
  /// Like start_solve, for the next step, called between start_accept and finish_accept; it holds
  /// if the `proposed_dt` of the acceptance is in this range. After finish_accept call
  /// finish_solve, or call_off_solve.
  virtual void start_next(const StepRequest&, const InterfaceValues&, const DtRange&) {
    throw Error("this solver takes one request at a time");
  }
  /// Forget what start_next began, whether it was solved or not.
  /// @pre  finish_accept was called
  virtual void call_off_solve() { throw Error("this solver takes one request at a time"); }

  /// Times since the start, by name of the call.
  virtual const std::map<std::string, CallTimes>& call_times() const = 0;
};

}  // namespace gabion
