// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "common/settings/scene.hpp"
#include "coupler/coupler_config.hpp"

namespace gabion {

/// A file of the scene, the solver that reads it, and the participant that this solver is.
struct SolverFile {
  std::string file;         ///< "mpm.json"
  std::string program;      ///< "mpm_solver"
  std::string participant;  ///< "soil"
};

/// The files that a run reads beside coupler.json: those whose participant is in coupler.json
/// without a command of its own, and whose program is there.
/// @param is_launched  whether a program of this name is there
std::vector<SolverFile> files_read(const Scene& scene, const CouplerSettings& settings,
                                   const std::function<bool(const std::string&)>& is_launched);

/// What has to hold from file to file: interfaces under the same names on both sides, none left
/// over, one dimension. What a file does wrong by itself is left to the solver that reads it.
/// @returns warnings, each with file, JSON pointer, what was found and what is expected
/// @throws ConfigError  with file, JSON pointer, found and allowed
std::vector<std::string> check_files(const Scene& scene, const CouplerSettings& settings,
                                     const std::vector<SolverFile>& files);

/// The participants that a launch brings along: those with a file that is read or with a command.
std::set<std::string> participants_here(const CouplerSettings& settings,
                                        const std::vector<SolverFile>& files);

/// Files that nobody reads, and participants that have to come from outside.
std::vector<std::string> check_attendance(const Scene& scene, const CouplerSettings& settings,
                                          const std::vector<SolverFile>& files);

}  // namespace gabion
