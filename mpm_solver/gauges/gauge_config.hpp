// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "common/settings/config_reader.hpp"
#include "mpm_solver/gauges/gauge.hpp"

namespace gabion::mpm {

/// Keys of an entry of "gauges".
KeyTable gauge_keys();

/// Read "gauges", warn of those that lie outside the grid.
/// @param grid  box around it [m]
/// @throws ConfigError
template <int dim>
std::vector<Gauge<dim>> read_gauges(ConfigReader& in, const Eigen::AlignedBox<double, dim>& grid);

}  // namespace gabion::mpm
