// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "common/settings/config_reader.hpp"

namespace gabion {

/// A factor that depends on time: piecewise linear through its rows, constant before the first and
/// after the last one; or a ramp `slope * t` without end.
class TimeFunction {
 public:
  static TimeFunction constant(double value) { return TimeFunction({0}, {value}, 0); }
  static TimeFunction ramp(double slope) { return TimeFunction({0}, {0}, slope); }
  /// @pre times strictly increasing, not empty, as many as values
  static TimeFunction table(std::vector<double> times, std::vector<double> values) {
    return TimeFunction(std::move(times), std::move(values), 0);
  }

  double at(double time) const;
  const std::vector<double>& values() const { return values_; }  ///< of the rows
  /// Whether the value never changes again from `time` on.
  bool constant_after(double time) const;

 private:
  TimeFunction(std::vector<double> times, std::vector<double> values, double slope)
      : times_(std::move(times)), values_(std::move(values)), slope_(slope) {}

  std::vector<double> times_;   // [s]
  std::vector<double> values_;  // at times_
  double slope_ = 0;            // [1/s], added to the table
};

/// @param unit      of the second column
/// @param sentence  what it is
Key time_table_key(const std::string& unit, const std::string& sentence);

/// Read the key "table": [[time, value], ...] of an object.
/// @throws ConfigError  empty table or times that do not increase
TimeFunction read_time_table(ConfigReader& in);

}  // namespace gabion
