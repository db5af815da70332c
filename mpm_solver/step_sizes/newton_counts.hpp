// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "common/settings/config_reader.hpp"

namespace gabion::mpm {

/// Counts of Newton's method: solutions by their number of iterations, failures by their cause.
class NewtonCounts {
 public:
  void add_solution(int iterations) { ++histogram_[iterations]; }
  /// @param cause  of the ConvergenceError
  void add_failure(const std::string& cause) { ++failures_[cause]; }

  /// Entry of summary.json: `solutions`, `iterations`, their `mean` and `max`, `histogram`
  /// (iterations -> solutions) and `failures` (cause -> number). Without a solution mean and max
  /// are null.
  Json json() const;
  std::int64_t solutions() const;
  std::int64_t iterations() const;
  double mean() const;  ///< iterations a solution, NaN without one
  /// The counts as one line for the log.
  std::string text() const;

 private:
  std::map<int, std::int64_t> histogram_;
  std::map<std::string, std::int64_t> failures_;
};

}  // namespace gabion::mpm
