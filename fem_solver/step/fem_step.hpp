// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/base/timer.hpp"
#include "common/run/solver.hpp"
#include "fem_solver/step/equilibrium.hpp"
#include "fem_solver/supports/boundary_conditions.hpp"

namespace gabion::fem {

/// Everything that the next step depends on.
struct FemState {
  double time = 0;  ///< [s]
  StructureMotion motion;
  std::vector<double> f_ext;  ///< loads and interface forces, num_nodes x dim [N]
  std::vector<double> f_int;  ///< internal forces, num_nodes x dim [N]
  /// Of the supports on the structure at the instant that the last step balanced, num_nodes x dim
  /// [N].
  std::vector<double> reactions;
  bool balanced = false;      ///< the motion solves the equations under f_ext
  double elastic_energy = 0;  ///< [J]
  double external_work = 0;   ///< of loads, interface forces and reactions since time 0 [J]
  /// Where the tangent matrix in use was assembled: part of the state, because modified Newton
  /// gives other last bits with another matrix.
  std::optional<TangentPoint> tangent;
  std::optional<SolutionMethod> rescue;  ///< LinearSolver::rescue() of that matrix

  /// Save or load; the arrays have their sizes already.
  void visit_state(StateVisitor& visitor);
};

/// Solves one step from an accepted state.
template <int dim>
class FemStep {
 public:
  FemStep(const FemSettings<dim>& settings, MPI_Comm comm);

  /// The state at time 0: static equilibrium under gravity and loads, or the reference
  /// configuration with the initial velocity and the accelerations that the loads demand.
  /// @throws ConvergenceError  there is no equilibrium
  FemState initial_state();
  /// A state at time 0 from given displacements and velocities; accelerations follow.
  FemState state_of(std::vector<double> u, std::vector<double> v);

  /// Solve from `state_n` to `state_n.time + dt`.
  ///
  /// The first call after `forget_iterates` starts from the state alone; the following ones start
  /// from the last solution. Repeating a call with the same arguments returns the same bits.
  /// @param f_interface  nodal forces of the interfaces at the end of the step [N]
  /// @throws ConvergenceError
  /// @note Collective.
  StepReport solve(const FemState& state_n, std::span<const double> f_interface, double dt,
                   FemState& trial);

  /// The accepted state changes, or the step begins anew.
  void forget_iterates();

  /// Nothing moves, and neither loads nor supports will change without the interface's doing.
  bool at_rest(const FemState& state) const;

  const Equilibrium<dim>& equilibrium() const { return equilibrium_; }
  const BoundaryConditions<dim>& conditions() const { return conditions_; }
  /// Counts, linear solver, and wall seconds by phase.
  Json summary() const;

 private:
  struct Iterate {
    std::vector<double> f_ext;
    double dt = 0;
    std::vector<double> du;
    FemState trial;
    StepReport report;
  };
  std::vector<double> external_forces(double time, std::span<const double> f_interface) const;
  std::vector<double> start_forces(const FemState& state_n, bool with_inertia) const;
  double work(const FemState& state_n, const FemState& trial, std::span<const double> du) const;
  bool nothing_changes(const FemState& state_n, std::span<const double> f_ext,
                       std::span<const double> constrained_u) const;
  std::vector<double> first_guess(const FemState& state_n, double dt) const;
  bool prepare_matrix(const FemState& state_n, double dt, bool with_inertia);
  NewtonReport solve_balance(const FemState& state_n, std::span<const double> f_ext, double dt,
                             bool with_inertia, std::vector<double>& du);
  void fill_trial(const FemState& state_n, std::vector<double> f_ext, double dt,
                  std::span<const double> du, FemState& trial);

  bool dynamic_;
  bool initial_equilibrium_;
  Vector<dim> initial_velocity_;
  NewtonSettings newton_;
  BoundaryConditions<dim> conditions_;
  Equilibrium<dim> equilibrium_;
  LinearSolver<dim> linear_;
  BlockMatrix<dim> K_;
  bool new_pattern_ = true;
  std::optional<TangentPoint> held_tangent_;  // of the matrix in linear_, where it may serve again
  std::vector<double> weight_;                // of the structure, by node [N]
  std::optional<Iterate> last_;
  PhaseTimes times_;
  std::int64_t solves_ = 0, skipped_solves_ = 0, repeated_solves_ = 0;
  std::int64_t newton_iterations_ = 0, restored_matrices_ = 0;
};

}  // namespace gabion::fem
