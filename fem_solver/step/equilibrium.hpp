// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/mechanics/newton/newton.hpp"
#include "common/mechanics/time_integration/newmark.hpp"
#include "fem_solver/step/damping.hpp"
#include "fem_solver/step/structure_state.hpp"
#include "fem_solver/stress/cell_integrals.hpp"
#include "fem_solver/supports/boundary_conditions.hpp"

namespace gabion::fem {

/// Forces of a state, num_nodes x dim of the held nodes each.
struct NodalForces {
  std::vector<double> internal;  ///< those of damping included [N]
  std::vector<double> inertia;   ///< [N], averaged and scaled as NewmarkBossak::inertia says
  double elastic_energy = 0;     ///< [J]
};

/// Balance of forces of one step (docs/theory/structure.md, (T4)):
///
///     r(du) = f' + force_memory f - M inertia(a', a) ,   f = f_ext - f_int - C v
///
/// with the weights of NewmarkBossak; in statics f' alone. Rows of constrained components are zero.
template <int dim>
class Equilibrium final : public NewtonProblem<dim> {
 public:
  /// Refers to mesh and ranks of the settings and to the conditions.
  /// @throws ConfigError  a cell that is not convex; on all ranks
  /// @note Collective, as all that sums over cells or nodes.
  Equilibrium(const FemSettings<dim>& settings, const BoundaryConditions<dim>& conditions,
              MPI_Comm comm);

  /// Set the step that `evaluate` is about. The motion must outlive its evaluations.
  /// @param f_ext    loads at the end of the step [N]
  /// @param f_start  loads minus internal forces at its start [N]; empty where the scheme has no
  ///                 force_memory. In statics the internal forces at its start, with which the
  ///                 residual is compared, too, since a step may end unloaded
  void begin_step(const StructureMotion& motion_n, std::span<const double> f_ext,
                  std::span<const double> f_start, double dt, bool with_inertia);

  /// Set the accepted history of the cells, from which evaluations continue. Null: none, or the
  /// virgin one.
  /// @returns  what is now the accepted one
  const CellHistory& set_history(CellHistory history);

  Evaluation evaluate(std::span<const double> du, std::span<double> r,
                      BlockMatrix<dim>* K) override;
  /// Regularise K at slack lines and membranes, whose force has a kink at the stress-free length.
  bool regularise(double share) override;
  /// Add stiffness at lines and membranes without force, which do not hold their nodes across.
  bool support(bool on) override;
  double increment_scale() const override { return smallest_cell_size_; }
  const SharedNodes& shared() const override { return ranks_.shared(); }
  std::string describe_node(std::size_t i) const override {
    return "node " + std::to_string(ranks_.node_of_all(static_cast<std::int32_t>(i)));
  }

  /// Motion at the end of the step. Constrained components follow their prescribed displacement
  /// with backward differences, so that a ramp does not ring.
  StructureMotion motion_after(std::span<const double> du) const;

  /// Put the history at the end of the step, and the work of yielding, brakes and damage, of the
  /// last evaluation, which was admissible, into a state.
  /// @param before  of the start of the step; null: there is none
  /// @note Collective.
  void find_history(StructureState& state, const StructureState* before) const;

  bool may_fail() const { return may_fail_; }  ///< cells of any rank may
  /// Internal forces without those of damping, of all ranks' cells [N], and their energy [J], of
  /// an admissible displacement.
  /// @note Collective.
  struct InternalForces {
    std::vector<double> f;
    double energy = 0;
  };
  InternalForces internal_forces(std::span<const double> u, const CellHistory& history);

  /// Forces of the last admissible evaluation.
  const NodalForces& forces() const { return forces_; }

  /// Accelerations from M a = f_ext - f_int(u) - C v, constrained components zero.
  std::vector<double> initial_acceleration(const StructureMotion& motion,
                                           std::span<const double> f_ext);

  bool cracks() const { return cells_.cracks(); }  ///< cells of any rank may
  bool damped() const { return damping_ != nullptr; }
  /// f += C v, of all ranks' cells. [N]
  void add_damping(std::span<const double> v, std::span<double> f) const;
  /// Work that damping took since time 0 [J]; a step adds du . C du / dt, which is never negative.
  double damping_work(const StructureState& state_n, const StructureState& next, double dt) const;

  /// M^-1 f, constrained components zero. The factor of M is kept. [unit of f / kg]
  std::vector<double> acceleration_of(std::span<const double> f);

  /// M y, of all ranks' cells. [kg x unit of y]
  std::vector<double> mass_times(std::span<const double> y) const;

  /// -dr/du at this displacement and for this step size.
  /// @pre the displacement is admissible
  void assemble_tangent(std::span<const double> u, double dt, bool with_inertia,
                        BlockMatrix<dim>& K);
  void set_pattern(BlockMatrix<dim>& K) const { cells_.set_pattern(K); }

  /// The point of the last tangent that was assembled.
  const TangentPoint& last_tangent() const { return last_tangent_; }

  const CellIntegrals<dim>& cells() const { return cells_; }
  const EmbeddedNodes<dim>& embedded() const { return embedded_; }
  const NewmarkBossak& scheme() const { return scheme_; }
  std::size_t num_dofs() const { return num_dofs_; }  ///< of the held nodes
  std::int32_t num_nodes_of_all() const { return num_nodes_of_all_; }
  bool symmetric() const { return symmetric_; }
  double wave_speed() const { return wave_speed_; }  ///< of P waves, the fastest [m/s]

 private:
  HistoryStep history_step();
  void find_wave_speed(const FemSettings<dim>& settings);
  void finish_tangent(double dt, bool with_inertia, BlockMatrix<dim>& K);
  double end_acceleration(std::size_t dof, double du) const;
  double end_velocity(std::size_t dof, double du, double a) const;

  /// Sums over the cells in a trial state.
  struct CellSums {
    std::span<const double> internal, inertia;  // of all ranks, num_nodes x dim [N], in buffer_
    double energy = 0;                          // of this rank's cells [J]
    std::string fault;                          // det F <= 0 in one of them; empty: in none
  };
  /// @pre u_trial_ is the displacement of this increment
  CellSums sum_cells(std::span<const double> du, BlockMatrix<dim>* K);
  /// @returns where a force of this rank is not finite; empty: nowhere
  std::string find_residual(const CellSums& sums, std::span<double> r) const;

  struct Mass {
    Mass(MPI_Comm comm, const LinearSolverSettings& settings) : solver(comm, dim, settings) {}
    BlockMatrix<dim> M;  // one rank: empty, the solver has a copy
    LinearSolver<dim> solver;
  };
  std::unique_ptr<Mass> factor_mass() const;

  MPI_Comm comm_;
  const MeshRanks& ranks_;
  const BoundaryConditions<dim>& conditions_;
  const EmbeddedNodes<dim>& embedded_;
  const Mesh<dim>& mesh_;
  CellIntegrals<dim> cells_;
  std::unique_ptr<Damping<dim>> damping_;  // null: none
  bool may_be_loose_;                      // a rank has membranes, or lines beside beams
  bool may_fail_;
  NewmarkBossak scheme_;
  double smallest_cell_size_ = 0;  // of all cells [m]
  std::size_t num_dofs_ = 0;
  std::int32_t num_nodes_of_all_ = 0;
  bool symmetric_ = true;
  double wave_speed_ = 0;
  std::vector<char> constrained_;  // by dof

  const StructureMotion* motion_n_ = nullptr;
  std::vector<double> f_ext_;  // with the share of the forces at the start of the step
  double dt_ = 0;
  bool with_inertia_ = false;
  double start_force_ = 0;  // forces at the start; in dynamics a share of |M v| / dt [N]
  NodalForces forces_;
  double regularisation_share_ = 0;
  bool support_ = false;
  CellHistory history_n_;
  std::vector<double> trial_history_;
  std::vector<double> u_trial_, v_trial_, a_mean_, buffer_;
  TangentPoint last_tangent_;
  std::unique_ptr<Mass> mass_;  // after the first acceleration_of()
};

}  // namespace gabion::fem
