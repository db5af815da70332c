// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/settings/config_reader.hpp"
#include "common/settings/time_function.hpp"

namespace gabion::mpm {

/// Largest rate of rain that is accepted [m/s]; the heaviest rain measured over a minute is 1e-3
/// m/s.
inline constexpr double most_rain = 1e-2;

KeyTable rain_keys();

/// Read {"rate"} or {"table"}: volume of water by horizontal area and time [m/s].
/// @throws ConfigError  neither or both, negative, more than most_rain
TimeFunction read_rain(ConfigReader in);

}  // namespace gabion::mpm
