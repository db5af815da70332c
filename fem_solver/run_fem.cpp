// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/run_fem.hpp"

#include "fem_solver/fem_config.hpp"
#include "fem_solver/fem_solver.hpp"

namespace gabion {

namespace {

template <int dim>
std::unique_ptr<Solver> make_solver(const Scene& scene, ConfigReader& in, MPI_Comm comm,
                                    const std::string& output_folder, AloneSettings* alone) {
  auto settings = fem::read_fem_settings<dim>(scene, in);
  if (alone) *alone = read_alone_settings(in);
  in.finish();
  return std::make_unique<fem::FemSolver<dim>>(comm, std::move(settings), output_folder);
}

}  // namespace

std::unique_ptr<Solver> make_fem_solver(const Scene& scene, ConfigReader& in, MPI_Comm comm,
                                        const std::string& output_folder, AloneSettings* alone) {
  return fem::read_dimension(in) == 2 ? make_solver<2>(scene, in, comm, output_folder, alone)
                                      : make_solver<3>(scene, in, comm, output_folder, alone);
}

void run_fem(const ProgramOptions& options, const MpiSession& session) {
  run_solver_program({"fem_solver", fem::fem_keys(), make_fem_solver}, options, session);
}

}  // namespace gabion
