// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <span>

namespace gabion::mpm {

/// A place between two neighbours of a row.
struct PlaceBetween {
  int first = -1;    ///< number of the lower neighbour, -1: outside the row
  double share = 0;  ///< share of the distance to the next one
};

/// Share of a spacing by which rounding may carry a place out of a row.
inline constexpr double row_rounding = 1e-9;

/// @param count  of places low, low + spacing, ...; at least 2
inline PlaceBetween place_between(double x, double low, double spacing, int count) {
  const double s = (x - low) / spacing;
  if (!(s >= -row_rounding && s <= count - 1 + row_rounding)) return {};
  const int first = std::clamp(static_cast<int>(std::floor(s)), 0, count - 2);
  return {first, std::clamp(s - first, 0.0, 1.0)};
}

/// @param places  at least 2, ascending
inline PlaceBetween place_between(double x, std::span<const double> places) {
  const double rounding = row_rounding * (places.back() - places.front());
  if (!(x >= places.front() - rounding && x <= places.back() + rounding)) return {};
  const auto above = std::upper_bound(places.begin() + 1, places.end() - 1, x);
  const auto first = static_cast<int>(above - places.begin()) - 1;
  const double share = (x - places[first]) / (places[first + 1] - places[first]);
  return {first, std::clamp(share, 0.0, 1.0)};
}

/// Linear between the values of two neighbours; equal ones give just that value, and one that does
/// not count is not asked for. @param value  of the lower (0) or upper (1) neighbour
template <class Value>
double between(const PlaceBetween& place, const Value& value) {
  if (place.share == 0) return value(0);
  if (place.share == 1) return value(1);
  return std::lerp(value(0), value(1), place.share);
}

}  // namespace gabion::mpm
