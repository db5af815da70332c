// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "common/settings/config_reader.hpp"
#include "mpm_solver/gauges/gauge.hpp"

namespace gabion::mpm {

/// Keys of an entry of "gauges".
KeyTable gauge_keys();

/// Read "gauges". @throws ConfigError
template <int dim>
std::vector<Gauge<dim>> read_gauges(ConfigReader& in);

}  // namespace gabion::mpm
