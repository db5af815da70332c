// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <memory>
#include <optional>
#include <span>

#include "common/base/timer.hpp"
#include "common/run/solver.hpp"
#include "mpm_solver/grid/transfer.hpp"
#include "mpm_solver/mpm_config.hpp"
#include "mpm_solver/report/ledger.hpp"
#include "mpm_solver/report/mpm_output.hpp"
#include "mpm_solver/step/equilibrium.hpp"
#include "mpm_solver/step/newton_counts.hpp"

namespace gabion::mpm {

/// The soil: implicit material point method in updated Lagrangian form (README.md).
///
/// One step: find the cells of the points, map mass and motion to the grid (P2G), solve the balance
/// of momentum of the active nodes by Newton's method, move the points with the grid (G2P).
/// @note Every function is collective over the ranks of `comm`.
template <int dim>
class MpmSolver final : public Solver {
 public:
  /// @param output_folder  folder of the frames; empty: none are written
  MpmSolver(MPI_Comm comm, MpmSettings<dim> settings, const std::string& output_folder);

  std::vector<InterfaceMesh> interfaces() const override;
  std::vector<std::string> probe_names() const override;
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

  const MaterialPoints<dim>& points() const { return points_; }
  /// Start from other velocities [m/s] and accelerations [m/s^2] of this rank's points, num_points
  /// each, at time 0.
  void set_motion(std::vector<Vector<dim>> v, std::vector<Vector<dim>> a);

 private:
  /// Everything of a step that does not depend on the interface values.
  void begin_step(const StepRequest& request);
  void enter_phase(double time);
  /// @param load_factor_n, load_factor  of gravity at the start and at the end of the step
  void make_equilibrium(double load_factor_n, double load_factor, double dt);
  /// Solve for the displacement that would balance the initial stress, and refuse it when large.
  void check_initial_stress();
  void map_to_nodes();
  void cure_small_cuts();
  std::vector<double> body_forces(double time) const;
  LinearRegime regime() const;
  void choose_guess();
  void spread_wall_step();
  NodalMotion<dim> nodal_motion() const;
  StepReport try_step(const StepRequest& request, const InterfaceValues& received,
                      InterfaceValues& sent);
  /// @throws ConvergenceError  a point would leave the grid; cause "outside"
  void refuse_exits() const;
  /// Take the points out that are outside the grid.
  void remove_outside(std::span<const std::int32_t> outside);
  StepMeasures measure_step() const;
  /// Size of the next step from the one that is accepted at `time`. @pre the points have not moved
  void propose_dt(double time);
  void log_new_dt(const StepRequest& request);
  void receive(const InterfaceValues& received);
  void move_rigid_walls(double time);
  void report_contact(StepReport& report, InterfaceValues& sent) const;
  void visit_state(StateVisitor& visitor);
  void find_probe_points();
  /// @throws ConfigError  a point lies outside the grid
  void locate_at_start();
  void prepare_averages();
  void log_grid() const;
  std::vector<std::int32_t> occupied_cells() const;
  /// Numbers of the step that was just accepted. @param cell_n  of each point before the step
  Json accepted_details(std::span<const std::int32_t> cell_n) const;
  const Phase& phase() const { return settings_.phases[phase_]; }
  WallConditions<dim>& walls() { return walls_of_phases_[phase_]; }
  std::vector<Vector<dim>> forces_on_walls() const;
  std::vector<double> forces_on_rigid_walls() const;

  MPI_Comm comm_;
  MpmSettings<dim> settings_;
  BackgroundGrid<dim> grid_;
  std::vector<WallConditions<dim>> walls_of_phases_;
  std::vector<std::string> wall_groups_;  // of all phases, each once
  double cell_size_;
  double wave_speed_ = 0;  // largest of the bodies [m/s]
  double soil_reach_ = 0;  // half the mean size of a material point [m]
  GridExits<dim> exits_;
  MaterialPoints<dim> points_;
  std::vector<BoundaryPoints<dim>> boundaries_;  // of the interfaces, then the rigid walls
  std::optional<GhostStiffness<dim>> ghost_;     // when a phase has it
  LinearSolver<dim> linear_;
  MpmOutput<dim> output_;
  Ledger<dim> ledger_;
  std::vector<Vector<dim>> wall_forces_;    // on wall_groups_ in the accepted state [N]
  std::vector<double> rigid_wall_forces_;   // force and moment of each in the accepted state
  std::vector<std::int32_t> probe_points_;  // of each probe; -1 on ranks that do not own it

  // the step under way
  double dt_ = 0;  // 0: none begun
  std::size_t phase_ = 0;
  bool with_inertia_ = true;
  bool ghost_acts_ = false;
  NewmarkBossak scheme_;
  PointWeights<dim> weights_;
  GridNodes<dim> nodes_;
  std::vector<double> f_body_, f_body_start_;  // at both ends; empty where nobody needs them
  TrialPoints<dim> trial_;
  BlockMatrix<dim> K_;
  std::optional<Equilibrium<dim>> equilibrium_;
  std::vector<double> du_;
  double initial_displacement_ = 0;  // that would balance the initial stress [m]
  std::int64_t joined_nodes_ = 0;    // of all steps

  StepControl control_;
  DtProposal proposal_;                   // for the step under way or the next one
  DtLimit logged_limit_ = DtLimit::none;  // of the last smaller dt in the log
  double accepted_dt_ = 0;                // of the last accepted step; 0: none
  int step_newton_ = 0;                   // most iterations of a solution of this step
  NewtonCounts newton_counts_;

  PhaseTimes times_;
  std::int64_t linear_iterations_ = 0;
  std::int64_t removed_points_ = 0;  // of all ranks
  std::int64_t ghost_steps_ = 0;     // steps in which a cell needed it
  std::int64_t ghost_facets_ = 0;    // of all steps
  std::int64_t capped_domains_ = 0;  // gimp: of this rank, added up over the accepted steps
};

}  // namespace gabion::mpm
