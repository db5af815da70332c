// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/parameters/counted_random.hpp"

#include <cmath>
#include <numbers>

namespace gabion::mpm {

namespace {

struct Product {
  std::uint32_t high, low;
};

Product multiply(std::uint32_t a, std::uint32_t b) {
  const std::uint64_t product = std::uint64_t{a} * b;
  return {static_cast<std::uint32_t>(product >> 32), static_cast<std::uint32_t>(product)};
}

// FNV-1a, 64 bit.
std::uint64_t hash(std::string_view text) {
  std::uint64_t value = 0xcbf29ce484222325ULL;
  for (const char letter : text) {
    value = (value ^ static_cast<unsigned char>(letter)) * 0x100000001b3ULL;
  }
  return value;
}

// A number in (0, 1] with 53 bits.
double unit(std::uint32_t high, std::uint32_t low) {
  const std::uint64_t bits = (std::uint64_t{high} << 32 | low) >> 11;
  return static_cast<double>(bits + 1) * 0x1p-53;
}

}  // namespace

std::array<std::uint32_t, 4> philox(const std::array<std::uint32_t, 4>& counter,
                                    const std::array<std::uint32_t, 2>& key) {
  std::array<std::uint32_t, 4> x = counter;
  std::array<std::uint32_t, 2> k = key;
  for (int round = 0; round < 10; ++round) {
    const Product a = multiply(0xD2511F53U, x[0]), b = multiply(0xCD9E8D57U, x[2]);
    x = {b.high ^ x[1] ^ k[0], b.low, a.high ^ x[3] ^ k[1], a.low};
    k[0] += 0x9E3779B9U;
    k[1] += 0xBB67AE85U;
  }
  return x;
}

CountedRandom::CountedRandom(std::uint64_t seed, std::string_view stream) {
  const std::uint64_t name = hash(stream);
  const auto low = static_cast<std::uint32_t>(name), high = static_cast<std::uint32_t>(name >> 32);
  key_ = {static_cast<std::uint32_t>(seed), low};
  stream_ = {high, static_cast<std::uint32_t>(seed >> 32)};
}

double CountedRandom::normal(std::uint64_t index) const {
  const auto low = static_cast<std::uint32_t>(index);
  const auto high = static_cast<std::uint32_t>(index >> 32);
  const auto words = philox({low, high, stream_[0], stream_[1]}, key_);
  const double radius = std::sqrt(-2 * std::log(unit(words[0], words[1])));
  return radius * std::cos(2 * std::numbers::pi * unit(words[2], words[3]));
}

}  // namespace gabion::mpm
