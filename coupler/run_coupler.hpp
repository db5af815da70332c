// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/program/program.hpp"
#include "coupler/coupler_config.hpp"
#include "protocol/wire/handshake.hpp"

namespace gabion {

/// Requirements of the handshake on each participant.
std::vector<Expected> expected_participants(const CouplerSettings& settings,
                                            const std::string& scene_hash);

/// Print the keys of coupler.json. @param form  "markdown" or "schema"
/// @throws ConfigError  another form
void describe_coupler_keys(const std::string& form);

/// The coupler as a program: read the scene, prepare the folder of results, listen, give the
/// endpoint to all programs of the launch, wait for the participants, run the coupling loop.
///
/// The participants get these settings of the run: "output" (folder), "end", "dt",
/// "output_interval".
/// @note Collective over the launch: every program in it must call session.share("coupler", …).
///       The folder of results exists when that call returns.
void run_coupler(const ProgramOptions& options, const MpiSession& session);

}  // namespace gabion
