// SPDX-License-Identifier: BSD-3-Clause
#include "common/settings/time_function.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace gabion {

double TimeFunction::at(double time) const {
  const double ramp = slope_ * time;
  if (time <= times_.front()) return values_.front() + ramp;
  if (time >= times_.back()) return values_.back() + ramp;
  const auto after = std::upper_bound(times_.begin(), times_.end(), time);
  const auto i = static_cast<std::size_t>(after - times_.begin());
  const double s = (time - times_[i - 1]) / (times_[i] - times_[i - 1]);
  return (1 - s) * values_[i - 1] + s * values_[i] + ramp;
}

bool TimeFunction::constant_after(double time) const {
  if (slope_ != 0) return false;
  const double value = at(time);
  for (std::size_t i = 0; i < times_.size(); ++i) {
    if (times_[i] > time && values_[i] != value) return false;
  }
  return true;
}

Key time_table_key(const std::string& unit, const std::string& sentence) {
  return key::rows("table", unit.empty() ? "s" : "s, " + unit, sentence)
      .wide(2, 2)
      .not_empty()
      .or_none();
}

TimeFunction read_time_table(ConfigReader& in) {
  const auto rows = in.rows("table", 2);
  std::vector<double> times, values;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (i > 0 && !(rows[i][0] > rows[i - 1][0])) {
      in.fail(fmt::format("table/{}", i),
              fmt::format("found time {} after {}, allowed: increasing times", rows[i][0],
                          rows[i - 1][0]));
    }
    times.push_back(rows[i][0]);
    values.push_back(rows[i][1]);
  }
  return TimeFunction::table(std::move(times), std::move(values));
}

}  // namespace gabion
