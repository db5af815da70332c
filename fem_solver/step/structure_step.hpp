// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/base/timer.hpp"
#include "common/run/solver.hpp"
#include "fem_solver/step/equilibrium.hpp"
#include "fem_solver/step/static_stability.hpp"
#include "fem_solver/step/structure_state.hpp"
#include "fem_solver/stress/cell_failure.hpp"
#include "fem_solver/supports/boundary_conditions.hpp"

namespace gabion::fem {

/// Solves one step from an accepted state.
template <int dim>
class StructureStep {
 public:
  StructureStep(const FemSettings<dim>& settings, MPI_Comm comm);

  /// The state at time 0: static equilibrium under gravity and loads, or the reference
  /// configuration with the initial velocity and the accelerations that the loads demand.
  /// @throws ConvergenceError  there is no equilibrium
  StructureState initial_state();
  /// A state at time 0 from given displacements and velocities; accelerations follow.
  StructureState state_of(std::vector<double> u, std::vector<double> v);

  /// Solve from `state_n` to `state_n.time + dt`.
  ///
  /// The first call after `forget_iterates` starts from the state alone; the following ones start
  /// from the last solution. Repeating a call with the same arguments returns the same bits.
  /// @param f_interface  nodal forces of the interfaces
  /// @param trial        complete but for what complete() does
  /// @throws ConvergenceError
  /// @note Collective.
  StepReport solve(const StructureState& state_n, const ExternalForces& f_interface, double dt,
                   StructureState& trial);

  /// Complete `trial` before it becomes the accepted state: velocity, acceleration and reactions
  /// where the mean forces differ from those of the step before (docs/theory/structure.md, (T9)),
  /// and the work of supports that moved.
  /// @note Collective.
  void complete(const StructureState& state_n, double dt, StructureState& trial);

  /// Let cells of a state that becomes the accepted one fail, and those that failed lose more of
  /// their stress. Elastic energy becomes failed energy. In dynamics the acceleration is that of
  /// the forces that are left, so that the next step makes no energy.
  /// @param state  complete
  /// @returns      those of this rank that begin to fail
  /// @note Collective.
  std::vector<Failure> fail_cells(double dt, StructureState& state);

  /// Forget the last solution: the accepted state changes, or the step begins anew.
  void forget_iterates() { last_.reset(); }

  /// Whether nothing moves, and neither loads nor supports will change by themselves.
  /// @note Collective.
  bool at_rest(const StructureState& state) const;

  const Equilibrium<dim>& equilibrium() const { return equilibrium_; }
  const BoundaryConditions<dim>& conditions() const { return conditions_; }
  /// Counts, linear solver, and wall seconds by phase.
  Json summary() const;

 private:
  struct Iterate {
    ExternalForces f;
    double dt = 0;
    std::vector<double> du;
    StructureState trial;
    StepReport report;
  };
  const SharedNodes& shared() const { return equilibrium_.shared(); }
  bool owns(std::size_t dof) const { return shared().owns(static_cast<std::int32_t>(dof / dim)); }
  ExternalForces external_forces(double time, const ExternalForces& f_interface) const;
  std::vector<double> balanced_forces(const StructureState& state_n, const ExternalForces& f) const;
  std::vector<double> start_forces(const StructureState& state_n, bool with_inertia) const;
  std::vector<double> kick_of(const std::vector<double>& f, double dt, const StructureState& trial);
  bool nothing_changes(const StructureState& state_n, const ExternalForces& f,
                       std::span<const double> constrained_u) const;
  std::vector<double> first_guess(const StructureState& state_n, double dt,
                                  bool moving = true) const;
  void explain_failure(const StructureState& state_n, const ConvergenceError& error) const;
  int approach(const StructureState& state_n, std::span<const double> f_ext, double dt,
               bool with_inertia, std::vector<double>& du);
  NewtonReport solve_from_guess(const StructureState& state_n, std::span<const double> f_ext,
                                double dt, std::vector<double>& du);
  bool prepare_matrix(const StructureState& state_n, double dt, bool with_inertia);
  NewtonReport solve_balance(const StructureState& state_n, std::span<const double> f_ext,
                             double dt, bool with_inertia, std::vector<double>& du);
  void fill_trial(const StructureState& state_n, ExternalForces f, double dt,
                  std::span<const double> du, StructureState& trial);

  bool dynamic_;
  bool initial_equilibrium_;
  Vector<dim> initial_velocity_;
  std::size_t num_places_;  // nodes without those of rotations
  bool beams_;
  bool slender_;
  NewtonSettings newton_, static_newton_;  // with inertia, without
  BoundaryConditions<dim> conditions_;
  Equilibrium<dim> equilibrium_;
  LinearSolver<dim> linear_;
  StaticStability<dim> stability_;
  BlockMatrix<dim> K_;
  std::optional<TangentPoint> held_tangent_;  // of the matrix in linear_, where it may serve again
  std::vector<double> weight_;                // of the structure, by node [N]
  std::optional<Iterate> last_;
  PhaseTimes times_;
  std::int64_t solves_ = 0, skipped_solves_ = 0, repeated_solves_ = 0;
  std::int64_t newton_iterations_ = 0, restored_matrices_ = 0;
};

}  // namespace gabion::fem
