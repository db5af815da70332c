// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cassert>
#include <cmath>
#include <vector>

namespace gabion::test {

/// Observed orders between successive refinements,
///
///     p_k = log(e_k / e_{k+1}) / log(h_k / h_{k+1})
///
/// @param sizes   mesh sizes or time steps h_k, falling   at least two
/// @param errors  e_k > 0, one each
inline std::vector<double> convergence_rates(const std::vector<double>& sizes,
                                             const std::vector<double>& errors) {
  assert(sizes.size() == errors.size() && sizes.size() >= 2);
  std::vector<double> rates;
  for (std::size_t k = 0; k + 1 < sizes.size(); ++k)
    rates.push_back(std::log(errors[k] / errors[k + 1]) / std::log(sizes[k] / sizes[k + 1]));
  return rates;
}

/// The rate of the last refinement.
inline double last_rate(const std::vector<double>& sizes, const std::vector<double>& errors) {
  return convergence_rates(sizes, errors).back();
}

/// The lowest of all rates.
inline double lowest_rate(const std::vector<double>& sizes, const std::vector<double>& errors) {
  const auto rates = convergence_rates(sizes, errors);
  return *std::min_element(rates.begin(), rates.end());
}

}  // namespace gabion::test
