// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/checks/surface_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace gabion {

namespace {

constexpr double ulps = 4 * std::numeric_limits<double>::epsilon();

}  // namespace

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
