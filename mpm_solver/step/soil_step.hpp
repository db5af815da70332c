// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/base/timer.hpp"
#include "mpm_solver/points/body_rotation.hpp"
#include "mpm_solver/step/explicit_step.hpp"
#include "mpm_solver/step/linear_system.hpp"
#include "mpm_solver/step/soil_on_grid.hpp"
#include "mpm_solver/step/soil_state.hpp"
#include "mpm_solver/step/step_sizes.hpp"

namespace gabion::mpm {

/// Solves one step from the accepted state: find the cells of the points, map mass and motion to
/// the grid (P2G), solve the balance of momentum of the active nodes by Newton's method, move the
/// points with the grid (G2P). Refers to model, state and times. Functions are collective.
template <int dim>
class SoilStep {
 public:
  SoilStep(const SoilModel<dim>& model, SoilState<dim>& state, PhaseTimes& times);

  /// Let soil under initial stress, if there is any, press on the surfaces with which it is in
  /// contact, and solve for the displacement that would balance it.
  /// @throws ConfigError  it is larger than InitialStress::max_displacement, or there is none
  void check_initial_stress();

  /// Solve from the state to request.time + request.dt; the state's surfaces then hold the forces.
  ///
  /// Iteration 0 of a step starts from the state alone, the following ones from the last solution.
  /// @param received  displacement of the interfaces at the end of the step
  /// @throws ConvergenceError
  StepReport solve(const StepRequest& request, const InterfaceValues& received);

  /// Make the last solution the accepted state.
  /// @returns without probes
  /// @pre `solved`: the last solution was one of this request
  AcceptReport accept(const StepRequest& request, bool solved);

  /// The step failed or is given up.
  void reject();
  /// The accepted state has changed: the next request begins a step.
  void forget() { dt_ = 0; }
  /// Between steps: give up the memory that only a step needs, for others who want much for a
  /// moment.
  void release() {
    if (dt_ != 0) return;
    equilibrium_.reset();
    trial_ = {};
    system_.release();
    soil_.release();
  }

  const SoilOnGrid<dim>& soil() const { return soil_; }
  const Phase& phase() const { return model_.settings.phases[phase_]; }
  const SubstepCounts& substep_counts() const { return explicit_.counts(); }
  const NewtonCounts& newton_counts() const { return sizes_.newton_counts(); }
  const LinearSolver<dim>& linear_solver() const { return system_.solver(); }
  const BlockMatrix<dim>& stiffness() const { return system_.K(); }
  std::int64_t linear_iterations() const { return linear_iterations_; }
  /// gimp: points whose domain was capped, of this rank, added up over the accepted steps.
  std::int64_t capped_domains() const { return capped_domains_; }
  /// Displacement that would balance the initial stress [m].
  double initial_displacement() const { return initial_displacement_; }

 private:
  void begin(const StepRequest& request);
  void begin_explicit(const StepRequest& request);
  void enter_phase(double time);
  void begin_at_rest(const Vector<dim>& gravity);
  bool takes_weight(double time) const;
  SoilSurface<dim> surface_of_soil(double dt) const;
  void map_soil(double dt);
  void make_equilibrium(const Vector<dim>& gravity_n, const Vector<dim>& gravity, double dt);
  LinearRegime regime() const;
  StepReport solve_implicit(const StepRequest& request, bool begins);
  StepReport solve_explicit(const StepRequest& request);
  StepReport solve_without_soil(const StepRequest& request, const InterfaceValues& received);
  AcceptReport accept_without_soil(const StepRequest& request);
  NewtonReport solve_balance(const StepRequest& request, bool begins);
  StepMeasures measure(const NodalMotion<dim>& motion) const;
  std::vector<Vector<dim>> forces_on_walls() const;
  Json details(std::span<const std::int32_t> cell_n) const;

  const SoilModel<dim>& model_;
  SoilState<dim>& state_;
  PhaseTimes& times_;
  SoilOnGrid<dim> soil_;
  StepSizes sizes_;
  double reach_ = 0;  // half the mean size of a material point at the start [m]
  LinearSystem<dim> system_;
  std::int64_t linear_iterations_ = 0;
  std::int64_t capped_domains_ = 0;
  double initial_displacement_ = 0;
  BodyRotations<dim> rotations_;

  // the current step
  double dt_ = 0;             // 0: none begun
  int first_iterations_ = 0;  // of Newton's method, of the first solution
  std::size_t phase_ = 0;
  bool with_inertia_ = true;
  bool takes_weight_ = false;  // SoilSurface::takes_weight
  bool forces_jump_ = false;   // at the start of the step: no acceleration is known
  NewmarkBossak scheme_;
  std::vector<double> f_body_, f_body_start_;  // at both ends; empty where nobody needs them
  SparseList<char> occupied_;  // SoilOnGrid::occupied_cells; empty where nobody asks
  TrialPoints<dim> trial_;
  std::optional<Equilibrium<dim>> equilibrium_;  // of an implicit step
  ExplicitStep<dim> explicit_;
  std::vector<double> du_;
};

}  // namespace gabion::mpm
