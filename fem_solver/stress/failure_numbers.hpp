// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include "fem_solver/stress/stress_integral.hpp"

namespace gabion::fem {

/// Numbers of failure, the last ones in the history of a cell or line that may fail; all are zero
/// before failure. They change only between steps, so that a step is a function of the accepted
/// state.
enum FailureNumber : std::size_t {
  lost_share,        ///< of its stress, 1: it is gone
  fade_time,         ///< over which the stress falls to zero [s]; > 0: it failed
  time_of_failure,   ///< [s]
  reason_of_failure  ///< FailureReason
};
inline constexpr std::size_t failure_numbers = 4;

/// @param history  of a cell that may fail
inline std::span<const double> failure_of(std::span<const double> history) {
  return history.last(failure_numbers);
}
inline std::span<double> failure_of(std::span<double> history) {
  return history.last(failure_numbers);
}

inline double share_left(std::span<const double> history) {
  return 1 - failure_of(history)[lost_share];
}

/// Copy what a step does not change: the numbers of failure, and of a cell that is gone all
/// numbers.
inline void keep_failure(double share, HistoryStep history) {
  const std::size_t size = share == 0 ? history.accepted.size() : failure_numbers;
  std::ranges::copy(history.accepted.last(size), history.trial.last(size).begin());
}

}  // namespace gabion::fem
