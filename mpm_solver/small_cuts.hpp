// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "mpm_solver/basis.hpp"

namespace gabion::mpm {

/// What is done about cells and nodes that hold little soil (README.md, section 3).
enum class SmallCutMethod {
  none,
  ghost,        ///< GhostStiffness
  mass_cutoff,  ///< join_light_nodes
};

struct SmallCutSettings {
  std::optional<SmallCutMethod> method;  ///< of all phases; not set: see method_in
  double ghost_factor = 1.0 / 30;        ///< of Young's modulus, > 0
  double mass_share =
      1e-4;  ///< of the mass of its points, see join_light_nodes: quasi-static and mass_cutoff
};

/// Method of a phase. Unless one is named, ghost stiffness where no inertia holds the nodes of
/// small cuts: quasi-static phases with the linear basis.
inline SmallCutMethod method_in(const SmallCutSettings& settings, Basis basis, bool dynamic) {
  if (settings.method) return *settings.method;
  return dynamic || basis != Basis::linear ? SmallCutMethod::none : SmallCutMethod::ghost;
}

}  // namespace gabion::mpm
