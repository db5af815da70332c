// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/base/timer.hpp"
#include "mpm_solver/points/body_rotation.hpp"
#include "mpm_solver/step/explicit_step.hpp"
#include "mpm_solver/step/implicit_step.hpp"
#include "mpm_solver/step/soil_on_grid.hpp"
#include "mpm_solver/step/soil_state.hpp"
#include "mpm_solver/step/surplus_motions.hpp"
#include "mpm_solver/step_sizes/step_sizes.hpp"

namespace gabion::mpm {

/// Makes one step from the accepted state: find the cells of the points, map mass and motion to the
/// grid (P2G), solve for the motion of the active nodes by the method of the phase, move the points
/// with the grid (G2P). Refers to model, state and times. Functions are collective.
template <int dim>
class SoilStep {
 public:
  SoilStep(const SoilModel<dim>& model, SoilState<dim>& state, PhaseTimes& times);

  /// Let soil under initial stress, if there is any, press on the surfaces with which it is in
  /// contact, and solve for the displacement that would balance it.
  /// @throws ConfigError  it is larger than InitialStress::max_displacement, or there is none
  void check_initial_stress();

  /// Begin a step from the accepted state: do all that does not depend on the interface values. A
  /// step begun before is given up.
  /// @throws ConvergenceError
  void begin(const StepRequest& request);
  /// Solve to request.time + request.dt; the state's surfaces then hold the forces.
  ///
  /// Iteration 0 of a step starts from the state alone, the following ones from the last solution.
  /// @param received  displacement of the interfaces at the end of the step
  /// @throws ConvergenceError
  /// @throws Error  no step of this time and dt has begun
  StepReport solve(const StepRequest& request, const InterfaceValues& received);

  /// Make the last solution the accepted state.
  /// @returns without probes
  /// @pre `solved`: the last solution was one of this request
  AcceptReport accept(const StepRequest& request, bool solved);

  /// Note that begin() or solve() has thrown.
  void note_failure(const ConvergenceError& error, double dt) { sizes_.add_failure(error, dt); }
  /// Reject the step, which failed or is abandoned.
  void reject();
  /// Abandon the current step, if there is one: the accepted state has changed.
  void forget() { under_way_ = false; }
  /// Release the memory that only a step needs. Called between steps, when another part of the
  /// program needs much for a moment.
  void release();

  void renew_surfaces() { soil_.renew_surfaces(); }  ///< interfaces have other facets
  const SoilOnGrid<dim>& soil() const { return soil_; }
  const Phase& phase() const { return model_.settings.phases[start_.phase]; }
  const NewtonCounts& newton_counts() const { return sizes_.newton_counts(); }
  const ImplicitStep<dim>& implicit_steps() const { return *implicit_; }
  const ExplicitStep<dim>& explicit_steps() const { return explicit_; }
  /// Points whose domain was capped (gimp), of this rank, added up over the accepted steps.
  std::int64_t capped_domains() const { return capped_domains_; }
  /// Displacement that would balance the initial stress [m].
  double initial_displacement() const { return initial_displacement_; }
  /// Discharge of the steady flow at the start [m^3/s]; none: its water was at rest.
  const std::optional<double>& initial_discharge() const { return initial_discharge_; }

 private:
  StepMethod<dim>& method_of(const Phase& phase);
  void enter_phase(const StepRequest& request);
  StepReport solve_once(const StepRequest& request, const InterfaceValues& received);
  StepReport solve_weaker(const StepRequest& request, const InterfaceValues& received);
  void begin_with(const StepRequest& request, const StrengthSearch& search);
  void begin_at_rest(const Vector<dim>& gravity, std::optional<double> deepest_row);
  SoilSurface<dim> surface_of_soil() const;
  void map_soil();
  void find_pore_pressures();
  PoolLevels pools_at(double time) const;
  std::vector<double> pool_pressures() const;
  void begin_surfaces();
  void check_surfaces();
  StepReport solve_soil(const StepRequest& request);
  StepReport solve_with_boulders(const StepRequest& request, const InterfaceValues& received);
  void move_points(const StepEnd<dim>& end);
  AcceptReport accept_without_soil(double time);
  StepMeasures measure(const StepEnd<dim>& end) const;
  std::vector<Vector<dim>> forces_on_walls(const StepMethod<dim>& method, double time) const;
  Json details(std::span<const std::int32_t> cell_n) const;
  double largest_step_from(double time) const;

  const SoilModel<dim>& model_;
  SoilState<dim>& state_;
  PhaseTimes& times_;
  SoilOnGrid<dim> soil_;
  StepSizes sizes_;
  double reach_ = 0;  // half the mean size of a material point at the start [m]
  std::int64_t capped_domains_ = 0;
  double initial_displacement_ = 0;
  std::optional<double> initial_discharge_;
  BodyRotations<dim> rotations_;

  // the current step, or the last one
  bool under_way_ = false;
  StepStart start_;
  StrengthSearch strength_;                     // after the current step
  std::vector<double> pore_pressures_;          // SoilSurface::pore_pressures
  std::vector<Symmetric<dim>> grain_stresses_;  // SoilSurface::grain_stresses
  std::vector<WaterOfBody<dim>> pore_waters_;   // SoilSurface::pore_waters
  SparseList<char> occupied_;  // SoilOnGrid::occupied_cells; empty where nobody asks
  SurplusMotions<dim> surplus_;
  TrialPoints<dim> trial_;
  std::unique_ptr<ImplicitStep<dim>> implicit_;
  ExplicitStep<dim> explicit_;
  StepMethod<dim>* method_ = nullptr;  // of the phase; null before the first step
};

}  // namespace gabion::mpm
