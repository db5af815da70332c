// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/run/run_keeper.hpp"
#include "common/run/run_record.hpp"
#include "common/run/solver.hpp"
#include "common/run/time_steps.hpp"

namespace gabion {

/// Time loop of a solver without coupler, its interfaces free. A step that does not converge is
/// repeated with dt/2.
///
/// Writes steps.csv (a row a step), probes.csv (also at time 0) and summary.json; asks the solver
/// for output at time 0, at the first step at or after each multiple of `output_interval`, and at
/// the end. A run that fails leaves everything written so far, the last accepted state, and a
/// summary with "completed": false and the reason.
///
/// @param output_interval  [s] > 0
/// @param keeper           null: no checkpoints. It writes one when due, at the end, and before the
///                         run ends at a signal. A run from a checkpoint writes the rows that
///                         follow.
/// @throws ConvergenceError  a step needs less than dt_min
/// @throws Interrupted       the keeper has got a signal
/// @throws ConfigError       the checkpoint is not before the end
/// @note Collective when the solver is: every rank calls it, records of other ranks do not write.
void run_alone(Solver& solver, const TimeSettings& settings, double output_interval,
               RunRecord& record, RunKeeper* keeper = nullptr);

}  // namespace gabion
