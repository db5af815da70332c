// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace gabion {

/// Numbers 0, 1, ... in sets that are joined one after the other; each set goes by its least number
/// (Tarjan 1975, without ranks, with halved paths).
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parents_(count) {
    std::iota(parents_.begin(), parents_.end(), 0);
  }

  std::int32_t find(std::int32_t i) {
    while (parents_[i] != i) i = parents_[i] = parents_[parents_[i]];
    return i;
  }
  void join(std::int32_t i, std::int32_t j) {
    i = find(i);
    j = find(j);
    if (j < i) std::swap(i, j);
    parents_[j] = i;
  }

 private:
  std::vector<std::int32_t> parents_;
};

}  // namespace gabion
