// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/run_mpm.hpp"

#include "mpm_solver/mpm_config.hpp"
#include "mpm_solver/mpm_solver.hpp"

namespace gabion {

namespace {

template <int dim>
std::unique_ptr<Solver> make_solver(const Scene& scene, ConfigReader& in, MPI_Comm comm,
                                    const std::string& output_folder, AloneSettings* alone) {
  return std::make_unique<mpm::MpmSolver<dim>>(comm, mpm::read_mpm_settings<dim>(scene, in, alone),
                                               output_folder);
}

}  // namespace

std::unique_ptr<Solver> make_mpm_solver(const Scene& scene, ConfigReader& in, MPI_Comm comm,
                                        const std::string& output_folder, AloneSettings* alone) {
  return in.integer("dimension") == 2 ? make_solver<2>(scene, in, comm, output_folder, alone)
                                      : make_solver<3>(scene, in, comm, output_folder, alone);
}

void run_mpm(const ProgramOptions& options, const MpiSession& session) {
  run_solver_program({"mpm_solver", mpm::mpm_keys(), make_mpm_solver}, options, session);
}

}  // namespace gabion
