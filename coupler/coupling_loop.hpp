// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "common/base/timer.hpp"
#include "common/run/balance_watch.hpp"
#include "common/run/loop_checkpoints.hpp"
#include "common/run/progress.hpp"
#include "common/run/run_record.hpp"
#include "common/run/time_steps.hpp"
#include "coupler/coupler_config.hpp"
#include "coupler/report/coupling_counts.hpp"
#include "coupler/report/coupling_record.hpp"
#include "coupler/step/coupled_step.hpp"
#include "coupler/step/interface_work.hpp"
#include "coupler/step/sides.hpp"

namespace gabion {

/// The time loop of a coupled run: step by step (CoupledStep), with the step sizes, the tables, the
/// frames and the checkpoints.
class CouplingLoop {
 public:
  /// @param participants  one for each entry of settings.participants, in any order
  /// @param keeper        null: no checkpoints; see run_alone()
  /// @throws ConfigError  participants or interfaces do not fit the settings
  CouplingLoop(const CouplerSettings& settings, const std::vector<NamedSolver>& participants,
               RunRecord& files, RunKeeper* keeper = nullptr);

  /// Run to the end. The files of a run that fails are complete up to the last accepted step, and
  /// summary.json says why it ended.
  /// @throws ConvergenceError  a step needs less than dt_min or fails at any dt, or on_limit is
  ///                           "stop"
  /// @throws Interrupted       the keeper has got a signal; after a checkpoint
  void run();

 private:
  void run_steps();
  void start();
  void advance();
  void accept(const Attempt& done, int cuts, const Stopwatch& watch);
  void start_next(const Attempt& done, double structures_dt);
  double allowed_dt(const Attempt& done, double proposed_dt) const;
  void record_step(const Attempt& done, int cuts, const Stopwatch& watch);
  void reject(const Attempt& failed);
  void write_output();
  void visit_state(StateVisitor& visitor);
  Json summary(bool participants_answer);

  CouplerSettings settings_;
  RunRecord& files_;
  PhaseTimes phases_;
  Sides sides_;
  CouplingRecord record_;
  CouplingCounts counts_;
  BalanceWatch balances_;
  CoupledStep step_;
  TimeSteps steps_;
  LoopCheckpoints checkpoints_;
  OutputClock clock_;
  Progress progress_;
  InterfaceWork soil_work_;
  InterfaceWork structure_work_;
  double soils_dt_ = 0;  // [s] that the soils proposed after the last step
  double written_ = -1;  // [s] time of the last frame
  Stopwatch watch_;
};

}  // namespace gabion
