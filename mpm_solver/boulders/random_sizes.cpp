// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/boulders/random_sizes.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "common/base/error.hpp"

namespace gabion::mpm {

namespace {

constexpr int most_draws = 100000;

double draw(const UniformSizes& sizes, int, RandomNumbers& random) {
  return random.between(sizes.min, sizes.max);
}

double draw(const LognormalSizes& sizes, int, RandomNumbers& random) {
  for (int k = 0; k < most_draws; ++k) {
    const double size = sizes.median * std::exp(sizes.deviation * random.normal());
    if (size >= sizes.min && size <= sizes.max) return size;
  }
  throw ConfigError(
      fmt::format("found no size from {} to {} m in {} draws with a median of {} m and a deviation "
                  "of {}, allowed: limits that hold a part of the distribution",
                  sizes.min, sizes.max, most_draws, sizes.median, sizes.deviation));
}

// A mass dP of size d is a number of dP / d^dim: on a piece of the curve, where dP goes by d(ln d),
// the number finer is linear in d^-dim.
double draw(const GradedSizes& sizes, int dim, RandomNumbers& random) {
  const auto& curve = sizes.curve;
  std::vector<double> numbers = {0};
  for (std::size_t k = 1; k < curve.size(); ++k) {
    const double low = std::pow(curve[k - 1][0], -dim), high = std::pow(curve[k][0], -dim);
    const double per_log =
        (curve[k][1] - curve[k - 1][1]) / std::log(curve[k][0] / curve[k - 1][0]);
    numbers.push_back(numbers.back() + per_log * (low - high));
  }
  const double at = random.between(0, numbers.back());
  std::size_t k = 1;
  while (k + 1 < curve.size() && at >= numbers[k]) ++k;
  const double low = std::pow(curve[k - 1][0], -dim), high = std::pow(curve[k][0], -dim);
  const double share = (at - numbers[k - 1]) / (numbers[k] - numbers[k - 1]);
  return std::pow(low + share * (high - low), -1. / dim);
}

}  // namespace

double RandomNumbers::between(double low, double high) {
  return low + (high - low) * (static_cast<double>(engine_() >> 11) * 0x1p-53);
}

// Box and Muller (1958).
double RandomNumbers::normal() {
  const double radius = std::sqrt(-2 * std::log(1 - between(0, 1)));
  return radius * std::cos(2 * std::numbers::pi * between(0, 1));
}

double draw_size(const SizeDistribution& sizes, int dim, RandomNumbers& random) {
  return std::visit([&](const auto& own) { return draw(own, dim, random); }, sizes);
}

}  // namespace gabion::mpm
