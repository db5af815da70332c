// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "solver_program/solver_program.hpp"

namespace gabion {

/// The solver of a scene's mpm.json, in the dimension it asks for.
/// @param alone  null, or filled: the scene has no coupler
/// @throws ConfigError
std::unique_ptr<Solver> make_mpm_solver(const Scene& scene, ConfigReader& in, MPI_Comm comm,
                                        const std::string& output_folder, AloneSettings* alone);

/// Print the keys of mpm.json. @param form  "markdown" or "schema"
/// @throws ConfigError  another form
void describe_mpm_keys(const std::string& form);

/// The program mpm_solver. @note Collective over session.comm().
void run_mpm(const ProgramOptions& options, const MpiSession& session);

}  // namespace gabion
