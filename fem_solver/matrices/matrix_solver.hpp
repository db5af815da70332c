// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <optional>
#include <string>
#include <vector>

#include "common/run/solver.hpp"
#include "common/run/start.hpp"
#include "common/settings/scene.hpp"
#include "fem_solver/interface/wet_surfaces.hpp"
#include "fem_solver/matrices/coordinates.hpp"
#include "fem_solver/matrices/linear_step.hpp"
#include "fem_solver/matrices/matrix_report.hpp"
#include "fem_solver/matrices/matrix_structure.hpp"

namespace gabion::fem {

/// A linear structure given as matrices, of any code: takes the forces on its wet surfaces and
/// gives their displacements at the cost of a back substitution (README.md).
/// @note Each rank of `comm` does the same.
template <int dim>
class MatrixSolver final : public Solver, public DisplacedAtStart {
 public:
  /// @param output_folder  folder of the frames; empty: none are written
  /// @throws ConfigError       wrong files or contradictory settings
  /// @throws ConvergenceError  modes of a reduction were not found
  MatrixSolver(MPI_Comm comm, const Scene& scene, MatrixSettings<dim> settings,
               const std::string& output_folder);

  std::vector<InterfaceMesh> interfaces() const override { return wet_surfaces_.meshes(); }
  std::vector<std::string> probe_names() const override { return report_.probe_names(); }
  bool takes_force_kinds() const override { return true; }
  void set_force_kinds(const ForceKinds& kinds) override { wet_surfaces_.set_force_kinds(kinds); }
  InterfaceValues start_displacements() const override;
  StepReport solve_step(const StepRequest& request, const InterfaceValues& received,
                        InterfaceValues& sent) override;
  AcceptReport accept_step(const StepRequest& request, bool solved) override;
  void reject_step() override;
  void write_output(double time) override;
  std::vector<double> probes() const override { return report_.probes(state_, step_); }
  Json summary() const override { return report_.summary(step_); }
  bool keeps_state() const override { return true; }
  State save_state() override;
  void load_state(const State& state) override;
  /// All ranks have the whole state.
  bool joins_states() const override { return true; }
  void join_states(const State& first, std::span<const State>) override { load_state(first); }

  const MatrixStructure<dim>& structure() const { return structure_; }
  const Coordinates& coordinates() const { return coordinates_; }
  const LinearState& state() const { return state_; }
  /// Start from other displacements and velocities of the unknowns [m, m/s], at time 0.
  /// @pre no reduction
  void set_motion(Eigen::VectorXd u, Eigen::VectorXd v);

 private:
  /// A component of a wet node that can move.
  struct WetComponent {
    std::size_t dof;  // node x dim + component
    int coordinate;
  };
  struct Trial {
    LinearForces f;
    Eigen::VectorXd u;
  };
  LinearState initial_state() const;
  std::vector<WetComponent> wet_components() const;
  LinearForces forces(const InterfaceValues& received) const;
  std::string fingerprint() const;
  void visit_state(StateVisitor& visitor);

  MatrixSettings<dim> settings_;
  MatrixStructure<dim> structure_;
  WetSurfaces<dim> wet_surfaces_;
  Coordinates coordinates_;
  std::vector<WetComponent> wet_components_;
  Eigen::VectorXd load_;  // on the coordinates [N]
  LinearStep step_;
  MatrixReport<dim> report_;
  LinearState state_;
  std::optional<Trial> trial_;
  std::vector<double> u_nodes_;  // num_nodes x dim; zero but on wet surfaces
};

}  // namespace gabion::fem
