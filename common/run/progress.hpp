// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "common/base/timer.hpp"

namespace gabion {

/// A wall time for a person: "75 s", "12 min 5 s", "3.4 h".
std::string duration_text(double seconds);

/// Tells a person how far a run is: one live line on a terminal, otherwise a log line every few
/// seconds or percent.
class Progress {
 public:
  /// @param end     [s] simulated time at which the run is done
  /// @param speaks  false on all ranks but the first
  Progress(double end, bool speaks);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  Progress(Progress&&) = delete;
  Progress& operator=(Progress&&) = delete;

  /// Call after each accepted step.
  void update(std::int64_t step, double time, double dt, int iterations);

 private:
  double end_;
  bool speaks_;
  bool terminal_;
  bool line_open_ = false;
  double last_shown_ = 0;     // [s] wall
  double last_fraction_ = 0;  // share of the simulated time
  Stopwatch watch_;
};

}  // namespace gabion
