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

/// Settings of a solver that runs without coupler: the objects "time", "output" and "checkpoint" of
/// its file.
struct AloneSettings {
  TimeSettings time;
  double output_interval = 0;  ///< [s] > 0
  CheckpointSettings checkpoint;
};
AloneSettings read_alone_settings(ConfigReader& in);
/// Keys of the root of a solver's file: "time", "output", "checkpoint".
std::vector<Key> alone_keys();

/// Reads the program's file of the scene and sets up the solver.
/// @param output_folder  empty: no frames
/// @param alone          null, or to be read from the same file
using MakeSolver = std::function<std::unique_ptr<Solver>(
    const Scene&, ConfigReader&, MPI_Comm, const std::string& output_folder, AloneSettings* alone)>;

/// A program around one Solver.
struct SolverProgram {
  std::string name;  ///< in the list of programs: "mpm_solver"
  KeyTable keys;     ///< of its file
  MakeSolver make;
};

/// Follow the coupler of the scene, or another scene's that --coupler names; or run alone when the
/// scene has no coupler.json. With `--check`, or when the coupler only checks: read the file and,
/// where a coupler is there, follow it to the first step; nothing is written.
/// @param program  of programs.hpp
/// @throws ConfigError, ProtocolError, ConvergenceError
/// @note Collective over session.comm().
void run_solver_program(const SolverProgram& program, const ProgramOptions& options,
                        const MpiSession& session);

}  // namespace gabion
