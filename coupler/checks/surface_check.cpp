// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/checks/surface_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace gabion {

namespace {

constexpr double thousand = 1000;
constexpr double thousand_tolerance = 0.05;  // the sides of one surface may end a facet apart
constexpr double ulps = 4 * std::numeric_limits<double>::epsilon();

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
      "; the structure's side extends over {:.4g}, the soil's over {:.4g}, a factor of about 1000: "
      "one of them seems to be in millimetres, allowed: metres",
      a, b);
}

std::vector<std::string> rounding_warnings(const CouplingSettings& coupling,
                                           const std::vector<InterfaceMesh>& surfaces,
                                           const std::string& file) {
  double largest = 0;
  for (const InterfaceMesh& mesh : surfaces) {
    for (const double x : mesh.coordinates) largest = std::max(largest, std::abs(x));
  }
  const double rounding = ulps * largest;
  std::vector<std::string> warnings;
  const auto compare = [&](const char* key, double found, const char* consequence) {
    if (found <= 0 || found >= rounding) return;
    warnings.push_back(fmt::format(
        "{}: at /coupling/{}: found {:g} m, below the rounding of coordinates up to {:g} m, which "
        "is {:.2g} m: {}",
        file, key, found, largest, rounding, consequence));
  };
  const FieldLimits& limits = coupling.convergence.displacement;
  compare("mapping/tolerance", coupling.mapping.tolerance,
          "vertices at the same place may count as too far apart");
  compare("convergence/displacement/absolute", limits.absolute.value_or(0),
          "contact forces change by more than it asks for, so that steps may not converge");
  compare("convergence/displacement/floor", limits.relative ? limits.floor : 0,
          "it is too small to stop the relative limit where displacements are rounding");
  return warnings;
}

}  // namespace gabion
