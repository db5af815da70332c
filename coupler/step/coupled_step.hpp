// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "common/base/timer.hpp"
#include "coupler/acceleration/acceleration.hpp"
#include "coupler/convergence/convergence.hpp"
#include "coupler/coupler_config.hpp"
#include "coupler/report/coupling_counts.hpp"
#include "coupler/report/coupling_record.hpp"
#include "coupler/step/attempt.hpp"
#include "coupler/step/contact_watch.hpp"
#include "coupler/step/coupling_scheme.hpp"
#include "coupler/step/predictor.hpp"
#include "coupler/step/sides.hpp"

namespace gabion {

/// The coupling of both sides within one step (docs/theory/coupling.md), with its memory from step
/// to step.
///
///     (solve, reject)*, solve, accept, (start_next, settle_next)?
class CoupledStep {
 public:
  /// @param record, counts  get each iteration
  /// @param phases          gets the time of the acceleration
  CoupledStep(const CouplingSettings& settings, Sides& sides, CouplingRecord& record,
              CouplingCounts& counts, PhaseTimes& phases);

  /// Iterate until both sides agree, or it is clear that they will not. If a solver cannot solve
  /// the step, the attempt has failed.
  Attempt solve(const StepRequest& request);
  /// Note that the sides accept this attempt. @param time  [s] at the end of the step
  void accept(const Attempt& done, double time);
  /// Interfaces have other facets: what earlier steps taught belongs to others.
  /// @param time  [s] of the accepted state
  void forget(double time, const Attempt& done);
  void reject() { acceleration_->discard_step(); }
  /// Start the soils on the next step, probably this request, while they still accept the last one.
  /// Call it after accept. @pre sides.take_next_step()
  /// @param proposed  range of proposed step sizes for which this request stays valid
  void start_next(const StepRequest& request, const DtRange& proposed);
  /// Keep or call off the early solution of the next step, once the sides have accepted.
  /// @param request  the next step as it is
  void settle_next(const StepRequest& request);
  /// Call off the early solution of the next step; no request is open afterwards.
  void call_off_next();
  /// Start at time 0 without displacement and force.
  void start_at_rest();

  /// [s] wall time of the acceleration since the last call.
  double take_acceleration_seconds();
  void visit_state(StateVisitor& visitor);

 private:
  Attempt iterate(const StepRequest& request);
  Attempt begin(const StepRequest& request);
  Attempt predict(const StepRequest& request) const;
  void accept_one_pass(bool contact, Attempt& now);
  void measure(Attempt& now);
  void end_unconverged(Attempt& now);
  /// Columns of earlier steps are dropped when the contact has changed, and when dt is less than
  /// half of theirs: the displacement of a structure with inertia is proportional to dt^2, so these
  /// columns would be too large.
  void forget_if_misleading(double dt);
  void forget_columns();
  void warn_of_round_off(const ConvergenceState& state);
  void log_iteration(Attempt& now, const Stopwatch& watch);
  void accelerate(Attempt& now);

  CouplingSettings settings_;
  Sides& sides_;
  CouplingRecord& record_;
  CouplingCounts& counts_;
  PhaseTimes& phases_;
  std::unique_ptr<CouplingScheme> scheme_;
  std::unique_ptr<Acceleration> acceleration_;
  Predictor predictor_;
  Convergence convergence_;
  ContactWatch contact_;
  std::optional<Attempt> next_;  // attempt that start_next began
  double columns_dt_ = 0;        // [s] of the newest step whose columns are kept
  int forgotten_columns_ = 0;    // dropped by the last reset, until the next call of `next`
  bool warned_round_off_ = false;
  double acceleration_seconds_ = 0;
};

}  // namespace gabion
