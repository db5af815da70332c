// SPDX-License-Identifier: BSD-3-Clause
#include "common/run/loop_checkpoints.hpp"

#include <fmt/format.h>

#include <utility>

#include "common/base/interrupt.hpp"
#include "common/base/log.hpp"
#include "common/base/require.hpp"

namespace gabion {

LoopCheckpoints::LoopCheckpoints(RunKeeper* keeper, const TimeSteps& steps,
                                 std::function<void(StateVisitor&)> visit_state, PhaseTimes& phases)
    : keeper_(keeper), steps_(steps), visit_state_(std::move(visit_state)), phases_(phases) {}

bool LoopCheckpoints::go_on() {
  const RestartPoint* const from = start();
  if (from == nullptr) return false;
  StateReader reader(from->run);
  try {
    visit_state_(reader);
  } catch (const Error&) {
    throw;
  } catch (const std::exception& problem) {
    throw Error(fmt::format("{}: the state of the run: {}", from->path, problem.what()));
  }
  require<ConfigError>(!steps_.finished(),
                       "{}: is at {} s, so nothing is left to do; allowed: a later end (/time/end)",
                       from->path, from->point.time);
  first_step_ = saved_ = steps_.step();
  log::info("continuing from {}, step {}, {} s", from->path, from->point.step, from->point.time);
  return true;
}

void LoopCheckpoints::after_step() {
  if (keeper_ == nullptr) return;
  const int signal = keeper_->signal();
  if (keeper_->due(steps_.step() - 1) || signal != 0) save();
  if (signal != 0) throw Interrupted(signal);
}

void LoopCheckpoints::at_end() {
  if (keeper_ != nullptr && saved_ != steps_.step()) save();
}

void LoopCheckpoints::save() {
  const ScopedTimer timer(phases_, "checkpoint");
  State run;
  StateWriter writer(run);
  visit_state_(writer);
  keeper_->save({steps_.step() - 1, steps_.time()}, run);
  saved_ = steps_.step();
}

Json LoopCheckpoints::summary() const {
  Json result = {{"steps", steps_.step() - first_step_}};
  if (start() != nullptr) result["restart"] = start()->summary();
  return result;
}

}  // namespace gabion
