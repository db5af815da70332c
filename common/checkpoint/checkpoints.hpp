// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/timer.hpp"
#include "common/checkpoint/checkpoint_folder.hpp"
#include "common/run/run_keeper.hpp"
#include "common/settings/config_reader.hpp"
#include "common/settings/scene.hpp"

namespace gabion {

/// The object "checkpoint" of coupler.json, or of a solver's own file when it runs alone. A
/// checkpoint is due after so many steps or minutes, whichever comes first, and at the end of the
/// run and at a signal.
struct CheckpointSettings {
  std::int64_t steps = 0;  ///< accepted steps from one to the next, >= 1; 0: do not count
  double minutes = 10;     ///< wall time from one to the next [min] > 0; 0: do not count
};
/// Read when checkpoints are due: without the object every 10 minutes, with it only as it says.
CheckpointSettings read_checkpoint_settings(ConfigReader& in);
KeyTable checkpoint_keys();

/// Checkpoints of one run: when they are due, what is in them, where the run started.
class Checkpoints final : public RunKeeper {
 public:
  /// The last checkpoint of an earlier run, checked against this scene.
  /// @param results  folder of that run as the user gave it
  /// @param output   folder of the results to come
  /// @throws ConfigError  no checkpoint; its scene is another one (file, JSON pointer, both
  /// values);
  ///                      `output` would overwrite it
  static Checkpoint load(const std::string& results, const std::string& output,
                         const std::string& kind, const Scene& scene);

  struct Parts {
    std::string folder;  ///< folder of the results
    std::string kind;    ///< kind of the run
    bool writes = true;  ///< false on all ranks but the first
    /// Names and Solver::save_state_to of the solvers; called by all ranks.
    std::vector<std::pair<std::string, std::function<State(const std::string&)>>> solvers;
    /// Makes one answer of those of all ranks: the largest.
    std::function<int(int)> agree = [](int value) { return value; };
  };
  Checkpoints(const CheckpointSettings& settings, const Scene& scene, Parts parts,
              std::optional<RestartPoint> start);

  const RestartPoint* start() const override { return start_ ? &*start_ : nullptr; }
  bool due(std::int64_t step) override;
  bool is_due(std::int64_t step) const override;
  void save(const RunPoint& point, const State& run) override;
  int signal() override;

 private:
  CheckpointSettings settings_;
  Json scene_;  // its identity
  Parts parts_;
  std::optional<RestartPoint> start_;
  std::int64_t last_step_ = 0;
  Stopwatch since_last_;
};

/// The step and time at which a run continues that loaded this checkpoint.
/// @param results  as the user gave it
RestartPoint restart_point(const std::string& results, const Checkpoint& checkpoint);

}  // namespace gabion
