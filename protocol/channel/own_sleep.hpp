// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <string>

#include "common/base/timer.hpp"

namespace gabion {

// A wait for a peer goes by slices, after which the peer's health is looked at.
inline constexpr int slice_milliseconds = 100;       // a death is noticed after one
inline constexpr double health_check_period = 0.05;  // [s]
inline constexpr double longest_slice = 1;           // [s], longer: this process did not run

/// Notices that this process did not run: it was suspended, or the machine had no time for it.
/// Complaints of peers after that are its consequence. Safe to use from several threads.
class OwnSleep {
 public:
  /// A thread that does nothing else calls this again and again.
  void tick() {
    const std::lock_guard lock(mutex_);
    const double gap = since_tick_.seconds();
    since_tick_ = Stopwatch();
    if (gap < longest_slice) return;
    last_ = gap;
    since_sleep_ = Stopwatch();
  }

  /// Length of a sleep that ended within the last moments [s]; 0: there was none.
  double recent() const {
    const std::lock_guard lock(mutex_);
    const double gap = since_tick_.seconds();
    const double last = since_sleep_.seconds() < moment ? last_ : 0;
    return std::max(gap < longest_slice ? 0 : gap, last);
  }

 private:
  static constexpr double moment = 10;  // [s]

  mutable std::mutex mutex_;
  Stopwatch since_tick_;
  Stopwatch since_sleep_;
  double last_ = 0;  // [s]
};

/// Reason of a failure after the coupler itself did not run: participants give up a coupler that
/// did not run for long, and it must not blame them. @param reason  the one that it would give
inline std::string after_own_sleep(double seconds, const std::string& reason) {
  return fmt::format(
      "the coupler's own process did not run for {:.1f} s: it was stopped, or the machine was too "
      "busy; then {}",
      seconds, reason);
}

}  // namespace gabion
