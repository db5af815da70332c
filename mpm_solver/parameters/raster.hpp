// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "common/mechanics/tensor.hpp"

namespace gabion::mpm {

/// Values at the centres of square cells over the first two coordinates, as an ESRI ASCII grid has
/// them.
struct Raster {
  std::string path;
  Vector<2> low = Vector<2>::Zero();  ///< centre of the cell in the south-west [m]
  double spacing = 0;                 ///< [m] > 0
  int columns = 0, rows = 0;          ///< at least 2
  std::vector<double> values{};       ///< rows from south to north; NaN: no data

  /// Bilinear between the centres of the cells.
  /// @throws ConfigError  outside of these, or a value it needs is missing
  double at(const Vector<2>& x) const;
};

/// Read an ESRI ASCII grid.
/// @param origin  place of the scene's zero point in coordinates of the file [m]
/// @throws ConfigError  names file and line
Raster read_raster(const std::string& path, const Vector<2>& origin);

}  // namespace gabion::mpm
