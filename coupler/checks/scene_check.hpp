// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "common/program/programs.hpp"
#include "common/settings/scene.hpp"
#include "coupler/coupler_config.hpp"

namespace gabion {

/// The programs whose files a run reads beside coupler.json: those whose participant is in
/// coupler.json without a command of its own, and that are there.
/// @param is_launched  whether a program of this name is there
std::vector<ProgramEntry> files_read(const Scene& scene, const CouplerSettings& settings,
                                     const std::function<bool(const std::string&)>& is_launched);

/// Check the files against each other: interfaces under equal names on both sides, none left over,
/// one dimension. Faults within one file are left to the solver that reads it.
/// @returns warnings, each with file, JSON pointer, what was found and what is expected
/// @throws ConfigError  with file, JSON pointer, found and allowed
std::vector<std::string> check_files(const Scene& scene, const CouplerSettings& settings,
                                     const std::vector<ProgramEntry>& files);

/// The participants that a launch brings along: those with a file that is read or with a command.
std::set<std::string> participants_here(const CouplerSettings& settings,
                                        const std::vector<ProgramEntry>& files);

/// Warnings of files that no program reads, and of participants that have to come from outside.
std::vector<std::string> check_attendance(const Scene& scene, const CouplerSettings& settings,
                                          const std::vector<ProgramEntry>& files);

}  // namespace gabion
