// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/run/solver.hpp"
#include "fem_solver/fem_config.hpp"
#include "fem_solver/interface/wet_surfaces.hpp"
#include "fem_solver/report/fem_output.hpp"
#include "fem_solver/report/fem_probes.hpp"
#include "fem_solver/step/fem_step.hpp"
#include "solver_program/solver_program.hpp"

namespace gabion::fem {

/// The structure: a finite element model that takes interface forces and gives displacements.
/// All functions are collective over the communicator.
template <int dim>
class FemSolver final : public Solver {
 public:
  /// @param output_folder  of the time series; empty: nothing is written
  /// @throws ConfigError       contradictory settings
  /// @throws ConvergenceError  no initial equilibrium
  FemSolver(FemSettings<dim> settings, MPI_Comm comm, const std::string& output_folder);

  std::vector<InterfaceMesh> interfaces() const override { return boundary_.meshes(); }
  std::vector<std::string> probe_names() const override { return probes_.names(); }
  StepReport solve_step(const StepRequest& request, const InterfaceValues& received,
                        InterfaceValues& sent) override;
  AcceptReport accept_step(const StepRequest& request, bool solved) override;
  void reject_step() override;
  void write_output(double time) override;
  std::vector<double> probes() const override;
  Json summary() const override;
  bool keeps_state() const override { return true; }
  State save_state() override;
  void load_state(const State& state) override;

  const FemState& state() const { return state_; }
  /// Start from other displacements and velocities, num_nodes x dim [m, m/s], at time 0.
  void set_motion(std::vector<double> u, std::vector<double> v);
  const Mesh<dim>& mesh() const { return settings_.mesh; }

 private:
  FemSettings<dim> settings_;
  WetSurfaces<dim> boundary_;
  FemProbes<dim> probes_;
  FemStep<dim> step_;
  FemState state_;
  std::optional<FemState> trial_;
  std::optional<FemOutput<dim>> output_;
};

/// The solver of a scene's fem.json, in the dimension it asks for.
/// @param alone  null, or filled: the scene has no coupler
/// @throws ConfigError
std::unique_ptr<Solver> make_fem_solver(const Scene& scene, ConfigReader& in, MPI_Comm comm,
                                        const std::string& output_folder,
                                        AloneSettings* alone = nullptr);

}  // namespace gabion::fem

namespace gabion {

using fem::FemSettings;
using fem::FemSolver;
using fem::make_fem_solver;

}  // namespace gabion
