// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "mpm_solver/grid/basis.hpp"
#include "mpm_solver/phases/phases.hpp"

namespace gabion::mpm {

/// Method for cells and nodes that hold little soil (docs/theory/soil.md, (S24)).
enum class SmallCutMethod {
  none,
  ghost,        ///< GhostStiffness
  mass_cutoff,  ///< join_light_nodes
};

/// Names in mpm.json and summary.json.
inline const std::map<std::string, SmallCutMethod> small_cut_methods = {
    {"none", SmallCutMethod::none},
    {"ghost", SmallCutMethod::ghost},
    {"mass_cutoff", SmallCutMethod::mass_cutoff}};

struct SmallCutSettings {
  std::optional<SmallCutMethod> method;  ///< of all phases; not set: see method_in
  double ghost_factor = 1.0 / 30;        ///< of Young's modulus, > 0
  /// A node below this share of the mass of its points joins another (join_light_nodes), where
  /// quasi-static or with mass_cutoff.
  double mass_share = 1e-4;
};

/// Method of a phase. Unless one is named, it is ghost stiffness where no inertia holds the nodes
/// of small cuts: in quasi-static phases, except with splines.
inline SmallCutMethod method_in(const SmallCutSettings& settings, Basis basis, bool dynamic) {
  if (settings.method) return *settings.method;
  return dynamic || basis == Basis::bspline ? SmallCutMethod::none : SmallCutMethod::ghost;
}

/// Whether any phase has this method.
inline bool any_has_method(SmallCutMethod method, const SmallCutSettings& settings, Basis basis,
                           const std::vector<Phase>& phases) {
  return std::any_of(phases.begin(), phases.end(), [&](const Phase& phase) {
    return method_in(settings, basis, phase.dynamic) == method;
  });
}

}  // namespace gabion::mpm
