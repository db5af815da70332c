// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace gabion {

/// Properties of one program of this project that the others know.
struct ProgramEntry {
  std::string name;          ///< "mpm_solver"
  std::string prefix;        ///< prefix of its log lines: "mpm"
  std::string participant;   ///< its name, in coupler.json too, unless --name says another: "soil"
  std::string about;         ///< first line of --help
  std::string file;          ///< its file in the scene: "mpm.json"
  std::string folder;        ///< folder of its frames below the results; empty: writes none
  bool sends_force = false;  ///< and receives displacement; else the reverse
};

/// The one list of them.
const ProgramEntry& coupler_program();
const std::vector<ProgramEntry>& solver_programs();

/// @throws Error  no program of this name
const ProgramEntry& program_entry(const std::string& name);

}  // namespace gabion
