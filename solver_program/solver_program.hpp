// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <functional>
#include <memory>
#include <string>

#include "common/checkpoint/checkpoints.hpp"
#include "common/program/mpi_session.hpp"
#include "common/program/program.hpp"
#include "common/run/solver.hpp"
#include "common/run/time_steps.hpp"
#include "common/settings/scene.hpp"

namespace gabion {

/// What a solver needs to know when no coupler does: the objects "time", "output" and "checkpoint"
/// of its file.
struct AloneSettings {
  TimeSettings time;
  double output_interval = 0;  ///< [s] > 0
  CheckpointSettings checkpoint;
};
AloneSettings read_alone_settings(ConfigReader& in);

/// Reads the program's file of the scene and sets up the solver.
/// @param output_folder  empty: no frames
/// @param alone          null, or to be read from the same file
using MakeSolver = std::function<std::unique_ptr<Solver>(
    const Scene&, ConfigReader&, MPI_Comm, const std::string& output_folder, AloneSettings* alone)>;

/// Follow the coupler of the scene, or another scene's that --coupler names; or run alone when the
/// scene has no coupler.json. With `--check`, or when the coupler only checks: read the file and,
/// where a coupler is there, follow it to the first step; nothing is written.
/// @param program  of programs.hpp
/// @throws ConfigError, ProtocolError, ConvergenceError
/// @note Collective over session.comm().
void run_solver_program(const std::string& program, const MakeSolver& make,
                        const ProgramOptions& options, const MpiSession& session);

}  // namespace gabion
