// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "common/run/state.hpp"

namespace gabion {

/// A place in a run, after an accepted step.
struct RunPoint {
  std::int64_t step = 0;  ///< accepted steps so far
  double time = 0;        ///< [s]
};

/// Start of a run that continues from a checkpoint.
struct RestartPoint {
  std::string path;  ///< path of the checkpoint, as the user gave it
  RunPoint point;
  State run;  ///< state of the time loop

  /// Entry for summary.json.
  Json summary() const { return {{"from", path}, {"step", point.step}, {"time", point.time}}; }
};

/// Keeps checkpoints of a time loop.
/// @note  Collective where the loop is; all ranks get the same answers.
class RunKeeper {
 public:
  virtual ~RunKeeper() = default;
  /// Null for a run from time 0. The solvers have loaded their states already.
  virtual const RestartPoint* start() const = 0;
  /// Whether a checkpoint is due after this many accepted steps. Asking counts as writing.
  virtual bool due(std::int64_t step) = 0;
  /// Like due(), as this rank sees it: the other ranks are not asked, and nothing counts as
  /// written.
  virtual bool is_due(std::int64_t step) const = 0;
  /// Write a checkpoint of the accepted state: that of the solvers and `run`, of the loop.
  /// @throws Error  it could not be written; the last one is still there
  virtual void save(const RunPoint& point, const State& run) = 0;
  /// Signal that asks the run to end, 0: none.
  virtual int signal() = 0;
};

}  // namespace gabion
