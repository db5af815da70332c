// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/settings/config_reader.hpp"
#include "common/settings/time_function.hpp"

namespace gabion::mpm {

/// Most rain that is taken for one in m/s; the heaviest that was measured is 1e-3 m/s of a minute.
inline constexpr double most_rain = 1e-2;

KeyTable rain_keys();

/// Read {"rate"} or {"table"}: volume of water by horizontal area and time [m/s].
/// @throws ConfigError  neither or both, negative, more than most_rain
TimeFunction read_rain(ConfigReader in);

}  // namespace gabion::mpm
