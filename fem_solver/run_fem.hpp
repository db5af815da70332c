// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "solver_program/solver_program.hpp"

namespace gabion {

/// The solver of a scene's fem.json, in the dimension it asks for.
/// @param alone  null, or filled: the scene has no coupler
/// @throws ConfigError
std::unique_ptr<Solver> make_fem_solver(const Scene& scene, ConfigReader& in, MPI_Comm comm,
                                        const std::string& output_folder, AloneSettings* alone);

/// Print the keys of fem.json. @param form  "markdown" or "schema"
/// @throws ConfigError  another form
void describe_fem_keys(const std::string& form);

/// The program fem_solver. @note Collective over session.comm().
void run_fem(const ProgramOptions& options, const MpiSession& session);

}  // namespace gabion
