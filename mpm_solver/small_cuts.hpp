// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace gabion::mpm {

/// What is done about cells and nodes that hold little soil (README.md, section 3).
enum class SmallCutMethod {
  none,
  ghost,        ///< GhostStiffness
  mass_cutoff,  ///< join_light_nodes
};

struct SmallCutSettings {
  SmallCutMethod method = SmallCutMethod::none;
  double ghost_factor = 1.0 / 30;  ///< of Young's modulus, > 0
  double mass_share = 0;  ///< of the mass of its points, see join_light_nodes; 0: none join
};

}  // namespace gabion::mpm
