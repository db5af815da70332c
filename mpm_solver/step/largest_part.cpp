// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step/largest_part.hpp"

#include <algorithm>

namespace gabion::mpm {

namespace {

// The limit is then known to 2^-rounds of the largest value.
constexpr int rounds = 64;

}  // namespace

// The limit is found by halving an interval that holds it, until one value or one number is left:
// those below are kept, those above left out.
double sum_without_largest(const SharedNodes& shared, std::vector<MassValue> values,
                           double left_out) {
  double low = 0, high = 0, kept = 0;
  for (const MassValue& v : values) high = std::max(high, v.value);
  high = shared.largest(high);
  for (int round = 0; round < rounds; ++round) {
    const double middle = 0.5 * (low + high);
    const auto upper = std::partition(values.begin(), values.end(),
                                      [&](const MassValue& v) { return v.value <= middle; });
    double sums[] = {0, static_cast<double>(values.size())};
    auto& [above, count] = sums;
    for (auto v = upper; v != values.end(); ++v) above += v->mass;
    shared.total(sums);
    if (count <= 1) break;
    if (above > left_out) {
      for (auto v = values.begin(); v != upper; ++v) kept += v->mass * v->value;
      values.erase(values.begin(), upper);
      low = middle;
    } else {
      values.erase(upper, values.end());
      left_out -= above;
      high = middle;
    }
  }
  double sums[] = {kept, 0, 0};
  auto& [all_kept, at_limit, mass_at_limit] = sums;
  for (const MassValue& v : values) {
    at_limit += v.mass * v.value;
    mass_at_limit += v.mass;
  }
  shared.total(sums);
  if (mass_at_limit <= left_out) return all_kept;
  return all_kept + at_limit * (1 - left_out / mass_at_limit);
}

}  // namespace gabion::mpm
