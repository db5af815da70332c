// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "common/mechanics/tensor.hpp"
#include "common/settings/config_reader.hpp"

namespace gabion::mpm {

/// Prescribed displacement of a rigid wall: velocity times time, or a table, piecewise linear and
/// constant before its first and after its last row. Neither: the wall is at rest.
struct WallMotion {
  std::vector<double> velocity;            ///< [m/s], dim values; empty: see table
  std::vector<std::vector<double>> table;  ///< rows [t, u_x, u_y(, u_z)], t strictly increasing

  bool moves() const { return !velocity.empty() || !table.empty(); }
  /// Displacement at a time [m]. @pre the settings have dim components
  template <int dim>
  Vector<dim> displacement(double time) const;
};

/// Read {"velocity": [..]} or {"table": [[t, ..], ..]}.
/// @throws ConfigError  neither or both, empty table, times that do not increase
WallMotion read_wall_motion(ConfigReader in, int dim);
KeyTable wall_motion_keys();

}  // namespace gabion::mpm
