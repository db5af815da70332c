// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

#include "common/base/timer.hpp"
#include "common/run/run_keeper.hpp"
#include "common/run/time_steps.hpp"

namespace gabion {

/// Checkpoints of a time loop: it continues from one, and writes them when due, at a signal and at
/// the end.
/// @note  Collective where the loop is.
class LoopCheckpoints {
 public:
  /// @param keeper       null: no checkpoints
  /// @param visit_state  the loop's state, `steps` included
  /// @param phases       gets the time of writing as "checkpoint"
  LoopCheckpoints(RunKeeper* keeper, const TimeSteps& steps,
                  std::function<void(StateVisitor&)> visit_state, PhaseTimes& phases);
  ~LoopCheckpoints() = default;
  LoopCheckpoints(const LoopCheckpoints&) = delete;  // it points into its loop
  LoopCheckpoints& operator=(const LoopCheckpoints&) = delete;
  LoopCheckpoints(LoopCheckpoints&&) = delete;
  LoopCheckpoints& operator=(LoopCheckpoints&&) = delete;

  /// Load the state of the loop.
  /// @returns false  the run starts at time 0
  /// @throws ConfigError  the checkpoint is not before the end
  bool go_on();
  /// Whether after_step is likely to write one; asked while a step is being accepted.
  bool is_likely() const { return keeper_ != nullptr && keeper_->is_due(steps_.step()); }
  /// Call after each accepted step.
  /// @throws Interrupted  the keeper has got a signal; after a checkpoint
  void after_step();
  void at_end();

  /// "steps" of this run, and "restart" where it continues from a checkpoint.
  Json summary() const;

 private:
  const RestartPoint* start() const { return keeper_ == nullptr ? nullptr : keeper_->start(); }
  void save();

  RunKeeper* keeper_;
  const TimeSteps& steps_;
  std::function<void(StateVisitor&)> visit_state_;
  PhaseTimes& phases_;
  std::int64_t first_step_ = 1;  // first step of this run
  std::int64_t saved_ = 0;       // current step at the last checkpoint
};

}  // namespace gabion
