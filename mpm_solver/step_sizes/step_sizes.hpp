// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/run/solver.hpp"
#include "mpm_solver/step_sizes/newton_counts.hpp"
#include "mpm_solver/step_sizes/step_control.hpp"

namespace gabion::mpm {

/// Keeps track of the effort of the steps, and proposes dt of the next one. Refers to a
/// StepControl.
class StepSizes {
 public:
  explicit StepSizes(StepControl& control) : control_(control) {}

  const StepControlSettings& limits() const { return control_.settings(); }
  /// Proposal after the last step.
  const DtProposal& proposal() const { return proposal_; }
  const NewtonCounts& newton_counts() const { return newton_counts_; }

  /// Begin a step: log that dt shrinks, unless the reason is that of the last time.
  void begin(const StepRequest& request);
  void add_solution(int newton_iterations);
  void add_failure(const ConvergenceError& error, double dt);
  void reject();
  /// @param step      but for newton_iterations, which is known here
  /// @param phase_dt  largest next step that the phase allows [s], 0: any
  void accept(StepMeasures step, double phase_dt);

 private:
  StepControl& control_;
  DtProposal proposal_;                   // for the current step or the next one
  DtLimit logged_limit_ = DtLimit::none;  // of the last smaller dt in the log
  double accepted_dt_ = 0;                // of the last accepted step; 0: none
  int step_newton_ = 0;                   // most iterations of a solution of this step
  NewtonCounts newton_counts_;
};

}  // namespace gabion::mpm
