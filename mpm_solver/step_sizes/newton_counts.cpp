// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step_sizes/newton_counts.hpp"

#include <fmt/format.h>

namespace gabion::mpm {

std::int64_t NewtonCounts::solutions() const {
  std::int64_t sum = 0;
  for (const auto& [iterations, count] : histogram_) sum += count;
  return sum;
}

std::int64_t NewtonCounts::iterations() const {
  std::int64_t sum = 0;
  for (const auto& [iterations, count] : histogram_) sum += iterations * count;
  return sum;
}

double NewtonCounts::mean() const {
  return static_cast<double>(iterations()) / static_cast<double>(solutions());
}

Json NewtonCounts::json() const {
  Json histogram = Json::object();
  for (const auto& [iterations, count] : histogram_) histogram[std::to_string(iterations)] = count;
  Json result = {{"solutions", solutions()}, {"iterations", iterations()}, {"mean", nullptr},
                 {"max", nullptr},           {"histogram", histogram},     {"failures", failures_}};
  if (!histogram_.empty()) {
    result["mean"] = mean();
    result["max"] = histogram_.rbegin()->first;
  }
  return result;
}

std::string NewtonCounts::text() const {
  if (histogram_.empty() && failures_.empty()) return "Newton: nothing solved";
  std::string text = fmt::format("Newton: {} solutions", solutions());
  if (!histogram_.empty()) {
    text += fmt::format(", {:.3g} iterations on average, {} at most", mean(),
                        histogram_.rbegin()->first);
  }
  for (const auto& [cause, count] : failures_) text += fmt::format(", {} x {}", count, cause);
  return text + (failures_.empty() ? ", no failure" : "");
}

}  // namespace gabion::mpm
