// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/settings/config_reader.hpp"

namespace gabion::fuzz {

/// Header first, then one frame an array, as decode() takes them.
using Frames = std::vector<std::string>;

/// The frames of accepted.json (20 times) and refused.json in a folder of test vectors.
std::vector<Frames> read_seeds(const std::string& folder);

/// Random numbers that are equal on every machine (SplitMix64: Steele, Lea, Flood 2014).
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next();
  /// 0 ... n - 1; n > 0.
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(next() % n); }
  bool one_in(std::size_t n) { return below(n) == 0; }

 private:
  std::uint64_t state_;
};

/// Spoils valid messages: input i of a seed is a function of the two numbers alone.
class Mutator {
 public:
  /// @param corpus  at least one
  Mutator(std::vector<Frames> corpus, std::uint64_t seed);

  Frames input(std::uint64_t index) const;

 private:
  std::vector<Frames> corpus_;
  std::vector<Json> headers_;  // of those in the corpus that are JSON
  std::uint64_t seed_;
};

}  // namespace gabion::fuzz
