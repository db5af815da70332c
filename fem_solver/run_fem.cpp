// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/run_fem.hpp"

#include "fem_solver/fem_solver.hpp"
#include "solver_program/solver_program.hpp"

namespace gabion {

void run_fem(const ProgramOptions& options, const MpiSession& session) {
  run_solver_program({.name = "fem_solver",
                      .participant = "structure",
                      .file = "fem.json",
                      .folder = "fem",
                      .keys = fem::fem_keys(),
                      .receives = force(),
                      .sends = displacement(),
                      .make = fem::make_fem_solver},
                     options, session);
}

}  // namespace gabion
