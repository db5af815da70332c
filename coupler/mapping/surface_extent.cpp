// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/mapping/surface_extent.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace gabion {

namespace {

constexpr double thousand = 1000;
constexpr double thousand_tolerance = 0.05;  // the sides of one surface may end a facet apart

}  // namespace

double extent(const InterfaceMesh& mesh) {
  double longest = 0;
  for (int i = 0; i < mesh.dim; ++i) {
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (std::int64_t v = 0; v < mesh.num_vertices(); ++v) {
      low = std::min(low, mesh.coordinates[v * mesh.dim + i]);
      high = std::max(high, mesh.coordinates[v * mesh.dim + i]);
    }
    longest = std::max(longest, high - low);
  }
  return longest;
}

std::string unit_hint(const InterfaceMesh& structure, const InterfaceMesh& soil) {
  const double a = extent(structure);
  const double b = extent(soil);
  const double ratio = std::max(a, b) / std::min(a, b);
  if (!(std::abs(ratio / thousand - 1) <= thousand_tolerance)) return "";
  return fmt::format(
      "; the structure's surface extends over {:.4g}, the soil's over {:.4g}, a factor of about "
      "1000: one of them seems to be in millimetres, allowed: metres",
      a, b);
}

}  // namespace gabion
