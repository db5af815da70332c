// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/run_fem.hpp"

#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "common/mechanics/petsc/petsc_session.hpp"
#include "common/settings/describe_keys.hpp"
#include "fem_solver/fem_config.hpp"
#include "fem_solver/fem_solver.hpp"
#include "fem_solver/matrices/matrix_solver.hpp"
#include "fem_solver/matrices/write_matrices.hpp"

namespace gabion {

namespace {

template <class Settings>
Settings finished(Settings settings, ConfigReader& in, AloneSettings* alone) {
  if (alone) *alone = read_alone_settings(in);
  in.finish();
  return settings;
}

template <int dim>
std::unique_ptr<Solver> make_solver(const Scene& scene, ConfigReader& in, MPI_Comm comm,
                                    const std::string& output_folder, AloneSettings* alone) {
  if (in.has("matrices")) {
    return std::make_unique<fem::MatrixSolver<dim>>(
        comm, scene, finished(fem::read_matrix_settings<dim>(in), in, alone), output_folder);
  }
  return std::make_unique<fem::FemSolver<dim>>(
      comm, finished(fem::read_fem_settings<dim>(scene, in, comm), in, alone), output_folder);
}

template <int dim>
void write_structure(const Scene& scene, ConfigReader& in, MPI_Comm comm,
                     const std::string& folder) {
  if (in.has("matrices")) in.fail("matrices", "--write-matrices: allowed: a structure with a mesh");
  AloneSettings alone;
  const auto settings = finished(fem::read_fem_settings<dim>(scene, in), in,
                                 scene.has("coupler.json") ? nullptr : &alone);
  fem::write_matrices<dim>(settings, in.resolved(), comm, folder);
  log::info("{}: written as matrices to {}", scene.path("fem.json"), folder);
}

void write_structure(const ProgramOptions& options, const MpiSession& session) {
  const PetscSession petsc(session.comm());
  const Scene scene(options.scene, options.overrides);
  ConfigReader in = scene.reader("fem.json", fem::fem_keys());
  if (fem::read_dimension(in) == 2) {
    write_structure<2>(scene, in, session.comm(), options.write_matrices);
  } else {
    write_structure<3>(scene, in, session.comm(), options.write_matrices);
  }
}

}  // namespace

std::unique_ptr<Solver> make_fem_solver(const Scene& scene, ConfigReader& in, MPI_Comm comm,
                                        const std::string& output_folder, AloneSettings* alone) {
  return fem::read_dimension(in) == 2 ? make_solver<2>(scene, in, comm, output_folder, alone)
                                      : make_solver<3>(scene, in, comm, output_folder, alone);
}

void describe_fem_keys(const std::string& form) {
  describe_keys(fem::fem_keys(), "fem.json", form);
}

void run_fem(const ProgramOptions& options, const MpiSession& session) {
  if (!options.write_matrices.empty()) {
    write_structure(options, session);
    return;
  }
  run_solver_program({"fem_solver", fem::fem_keys(), make_fem_solver}, options, session);
}

}  // namespace gabion
