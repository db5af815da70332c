// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/program/mpi_session.hpp"

namespace gabion {

/// Arguments of the command line of each of the three programs.
struct ProgramOptions {
  std::string scene;                   ///< folder
  std::string output;                  ///< folder of results
  std::string restart;                 ///< results of the run to continue; empty: from time 0
  std::vector<std::string> overrides;  ///< "FILE:/json/pointer=VALUE", for Scene
  std::string log_level = "info";      ///< error, warn, info or debug
  bool check = false;                  ///< read and cross-check the scene, then end
  std::string coupler;   ///< endpoint: solvers connect to it, the coupler binds it; empty = by MPI
  std::string name;      ///< name of this participant, such as "soil"
  std::string key_file;  ///< solvers: own secret key, when the coupler asks for keys
  std::string coupler_key_file;    ///< solvers: the coupler's public key
  std::string make_keys;           ///< coupler: write a new pair of keys to this file, then end
  double connect_deadline = 30;    ///< [s] > 0, solvers: until the coupler has answered
  std::string describe_keys;       ///< "markdown" or "schema": print the keys of its file, then end
  bool list_participants = false;  ///< coupler: print who takes part and how, then end
  std::string check_participant;   ///< coupler: drive this participant through a check, then end
  int advise_ranks = -1;           ///< mpm_solver: print how many ranks pay on so many cores (0: on
                                   ///< those it may use), then end; negative: not asked
  std::string write_varying;       ///< mpm_solver: write constants that vary there, then end
  std::string write_matrices;      ///< fem_solver: write the structure as matrices there, then end
  double amplitude = 0;            ///< size of that check's values [N or m]; 0 = not given
};

/// Frame of a program: options, log, MPI, and errors as exit codes.
///
///     int main(int argc, char** argv) {
///       return gabion::run_program(argc, argv, "fem_solver", describe_fem_keys, run_fem);
///     }
///
/// Options are read and keys described before MPI starts, so --help and --describe-keys need no
/// launch. An Error ends the program with its exit_code(), any other exception with 4; other
/// programs of the launch are taken down. The default of --output is results/<scene>, for a solver
/// that runs without coupler results/<scene>_<program>.
///
/// @param program   of programs.hpp
/// @param describe  prints the keys of the program's file in a form: ProgramOptions::describe_keys
/// @returns exit code
int run_program(int argc, char** argv, const std::string& program,
                const std::function<void(const std::string& form)>& describe,
                const std::function<void(const ProgramOptions&, const MpiSession&)>& body);

}  // namespace gabion
