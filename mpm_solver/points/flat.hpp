// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

namespace gabion {

/// The numbers of vectors or tensors of fixed size, one after the other.
template <class Tensor>
std::span<double> flat(std::vector<Tensor>& values) {
  if (values.empty()) return {};
  return {values.front().data(), values.size() * values.front().size()};
}

template <class Tensor>
std::span<const double> flat(const std::vector<Tensor>& values) {
  if (values.empty()) return {};
  return {values.front().data(), values.size() * values.front().size()};
}

}  // namespace gabion
