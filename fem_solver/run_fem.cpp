// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/run_fem.hpp"

#include "fem_solver/fem_solver.hpp"
#include "solver_program/solver_program.hpp"

namespace gabion {

void run_fem(const ProgramOptions& options, const MpiSession& session) {
  run_solver_program("fem_solver", fem::make_fem_solver, options, session);
}

}  // namespace gabion
