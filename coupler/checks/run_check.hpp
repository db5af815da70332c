// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "common/settings/scene.hpp"
#include "coupler/coupler_config.hpp"
#include "protocol/server/server.hpp"
#include "protocol/wire/handshake.hpp"

namespace gabion {

/// Size of a run in which every step has the first size.
struct RunSize {
  std::int64_t steps = 0;
  std::int64_t frames = 0;  ///< written by each solver
};
RunSize run_size(const TimeSettings& time, double output_interval);

/// A coupled run up to its first step: wait for these participants, map the surfaces that they
/// share, log how these fit and how large the run will be, and end the run. The coupler writes no
/// file.
/// @param expected  participants that connect; the surfaces of others are named as not checked
/// @param run       settings that they get
/// @throws ConfigError, ProtocolError  as a run would
void check_run(Server& server, const CouplerSettings& settings,
               const std::vector<Expected>& expected, const Json& run, const Scene& scene);

}  // namespace gabion
