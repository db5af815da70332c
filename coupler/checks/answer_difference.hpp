// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>
#include <string>

namespace gabion {

/// Difference of two answers to the same request.
struct AnswerDifference {
  std::string text;     ///< empty: the bits are equal; else where they differ most
  double relative = 0;  ///< largest difference by the largest value

  /// @param a, b  values of `name`, as many and `components` a vertex
  void add(const std::string& name, int components, std::span<const double> a,
           std::span<const double> b) {
    const auto dim = static_cast<std::size_t>(components);
    for (std::size_t i = 0; i < a.size(); ++i) {
      largest_value_ = std::max({largest_value_, std::abs(a[i]), std::abs(b[i])});
      double by = std::abs(a[i] - b[i]);
      if (std::isnan(by)) by = std::numeric_limits<double>::infinity();
      if (std::memcmp(&a[i], &b[i], sizeof(double)) == 0 || by <= largest_) continue;
      largest_ = by;
      text = fmt::format(
          "differs by {:.3g} ({:.17g}, then {:.17g}) at \"{}\", vertex {}, component {}", by, a[i],
          b[i], name, i / dim, i % dim);
    }
    relative = largest_ > 0 ? largest_ / largest_value_ : 0;
  }

  /// @param a, b  lists that may differ in length
  void add_list(const std::string& name, std::span<const double> a, std::span<const double> b) {
    if (a.size() == b.size()) return add(name, 1, a, b);
    text = fmt::format("\"{}\": {} numbers, then {}", name, a.size(), b.size());
    relative = std::numeric_limits<double>::infinity();
  }

 private:
  double largest_ = -1;
  double largest_value_ = 0;
};

}  // namespace gabion
