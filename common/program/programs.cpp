// SPDX-License-Identifier: BSD-3-Clause
#include "common/program/programs.hpp"

#include <algorithm>

#include "common/base/require.hpp"

namespace gabion {

const ProgramEntry& coupler_program() {
  static const ProgramEntry coupler = {.name = "coupler",
                                       .prefix = "cpl",
                                       .participant = "coupler",
                                       .about = "Couples a soil and a structure.",
                                       .file = "coupler.json",
                                       .folder = ""};
  return coupler;
}

const std::vector<ProgramEntry>& solver_programs() {
  static const std::vector<ProgramEntry> solvers = {
      {.name = "mpm_solver",
       .prefix = "mpm",
       .participant = "soil",
       .about = "Material point method for the soil.",
       .file = "mpm.json",
       .folder = "mpm",
       .sends_force = true},
      {.name = "fem_solver",
       .prefix = "fem",
       .participant = "structure",
       .about = "Finite elements for the structure.",
       .file = "fem.json",
       .folder = "fem",
       .sends_force = false},
  };
  return solvers;
}

const ProgramEntry& program_entry(const std::string& name) {
  if (name == coupler_program().name) return coupler_program();
  const auto& solvers = solver_programs();
  const auto found = std::find_if(solvers.begin(), solvers.end(),
                                  [&](const ProgramEntry& entry) { return entry.name == name; });
  require(found != solvers.end(), "no program \"{}\"", name);
  return *found;
}

}  // namespace gabion
