// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <random>
#include <variant>
#include <vector>

namespace gabion::mpm {

/// Random numbers that are the same on every machine and every rank.
class RandomNumbers {
 public:
  explicit RandomNumbers(std::uint64_t seed) : engine_(seed) {}

  double between(double low, double high);  ///< uniform
  double normal();                          ///< of mean 0 and deviation 1

 private:
  std::mt19937_64 engine_;
};

/// Sizes by number, all equally likely [m].
struct UniformSizes {
  double min = 0, max = 0;
};

/// Sizes by number whose logarithm is normal, those out of the limits left out.
struct LognormalSizes {
  double median = 0;        ///< [m]
  double deviation = 0;     ///< of the natural logarithm
  double min = 0, max = 0;  ///< [m]
};

/// A grading curve: [size in m, share of the mass that is finer], ascending, from 0 to 1. Between
/// its points the share is linear in the logarithm of the size.
struct GradedSizes {
  std::vector<std::array<double, 2>> curve;
};

using SizeDistribution = std::variant<UniformSizes, LognormalSizes, GradedSizes>;

/// A size [m].
/// @param dim  mass goes by size^dim
/// @throws ConfigError  limits of a lognormal distribution that hold next to nothing of it
double draw_size(const SizeDistribution& sizes, int dim, RandomNumbers& random);

}  // namespace gabion::mpm
