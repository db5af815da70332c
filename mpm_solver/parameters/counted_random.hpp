// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace gabion::mpm {

/// Philox4x32-10 of Salmon, Moraes, Dror, Shaw (2011): four random words of a counter and a key,
/// without a state, so that any process finds the number of any place by itself.
std::array<std::uint32_t, 4> philox(const std::array<std::uint32_t, 4>& counter,
                                    const std::array<std::uint32_t, 2>& key);

/// Random numbers of a seed and a stream, each found from its number alone.
class CountedRandom {
 public:
  /// @param stream  a text; numbers of different streams are independent
  CountedRandom(std::uint64_t seed, std::string_view stream);

  /// A number of mean 0 and deviation 1, normally distributed (Box and Muller).
  double normal(std::uint64_t index) const;

 private:
  std::array<std::uint32_t, 2> key_;
  std::array<std::uint32_t, 2> stream_;
};

}  // namespace gabion::mpm
