// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>

#include "common/run/run_keeper.hpp"

namespace gabion {

/// A checkpoint: the states of a run's parts ("run", and its solvers) after one step.
struct Checkpoint {
  RunPoint point;
  std::map<std::string, State> states;

  /// @throws ConfigError  no part of this name, with those that exist
  const State& state_of(const std::string& part) const;
};

/// RESULTS/checkpoints/step_000123, there or not.
std::string checkpoint_path(const std::string& results, const RunPoint& point);

/// An empty folder checkpoint_path() for files of solvers, that does not count yet.
void begin_checkpoint(const std::string& results, const RunPoint& point);

/// Write checkpoint_path() with a file NAME.h5 a part, where a solver has not written it
/// (State::file), then its manifest.json with size and checksum of each file, then remove older
/// checkpoints. All of it is flushed to the disk before the manifest gets its name, and a
/// folder without manifest does not count: whatever ends the program, a whole checkpoint is left.
/// @param kind  of the run, as in RunRecord
/// @throws Error  disk full, folder gone; the last checkpoint is still there
void write_checkpoint(const std::string& results, const std::string& kind,
                      const Checkpoint& checkpoint);

/// Path of the last whole checkpoint of a run.
/// @param results  folder of that run
/// @throws ConfigError  no such folder, or no checkpoint in it
std::string find_checkpoint(const std::string& results);

/// @param path  from find_checkpoint
/// @throws ConfigError  of another kind of run, or another format
/// @throws Error        damaged: a file of another size or checksum than the manifest says. A
///                      manifest of format 1 has no checksums, which is logged as a warning.
Checkpoint read_checkpoint(const std::string& path, const std::string& kind);

}  // namespace gabion
