// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/mechanics/newton/newton.hpp"
#include "common/mechanics/time_integration/newmark.hpp"
#include "fem_solver/step/structure_state.hpp"
#include "fem_solver/stress/cell_integrals.hpp"
#include "fem_solver/supports/boundary_conditions.hpp"

namespace gabion::fem {

/// Forces of a state, num_nodes x dim each.
struct NodalForces {
  std::vector<double> internal;  ///< [N]
  std::vector<double> inertia;   ///< [N], averaged and scaled as NewmarkBossak::inertia says
  double elastic_energy = 0;     ///< [J]
};

/// Balance of forces of one step (docs/theory/structure.md, (T4)):
///
///     r(du) = f' + force_memory f - M inertia(a', a) ,   f = f_ext - f_int
///
/// with the weights of NewmarkBossak; in statics f' alone. Rows of constrained components are zero.
template <int dim>
class Equilibrium final : public NewtonProblem<dim> {
 public:
  Equilibrium(const FemSettings<dim>& settings, const BoundaryConditions<dim>& conditions,
              MPI_Comm comm);

  /// Set the step that `evaluate` is about. The motion must outlive its evaluations.
  /// @param f_ext    loads at the end of the step [N]
  /// @param f_start  loads minus internal forces at its start [N]; empty where the scheme has no
  ///                 force_memory, and in statics
  void begin_step(const StructureMotion& motion_n, std::span<const double> f_ext,
                  std::span<const double> f_start, double dt, bool with_inertia);

  Evaluation evaluate(std::span<const double> du, std::span<double> r,
                      BlockMatrix<dim>* K) override;
  double increment_scale() const override { return cells_.smallest_cell_size(); }

  /// Motion at the end of the step. Constrained components follow their prescribed displacement
  /// with backward differences, so that a ramp does not ring.
  StructureMotion motion_after(std::span<const double> du) const;

  /// Forces of the last admissible evaluation.
  const NodalForces& forces() const { return forces_; }

  /// Accelerations from M a = f_ext - f_int(u), constrained components zero.
  std::vector<double> initial_acceleration(std::span<const double> u,
                                           std::span<const double> f_ext);

  /// M^-1 f, constrained components zero. The factor of M is kept. [unit of f / kg]
  std::vector<double> acceleration_of(std::span<const double> f);

  /// M y, all ranks' cells. [kg x unit of y]
  std::vector<double> mass_times(std::span<const double> y) const;

  /// -dr/du at this displacement and for this step size.
  /// @pre the displacement is admissible
  void assemble_tangent(std::span<const double> u, double dt, bool with_inertia,
                        BlockMatrix<dim>& K);
  void set_pattern(BlockMatrix<dim>& K) const { cells_.set_pattern(K); }

  /// Of the last tangent that was assembled.
  const TangentPoint& last_tangent() const { return last_tangent_; }

  const CellIntegrals<dim>& cells() const { return cells_; }
  const NewmarkBossak& scheme() const { return scheme_; }
  std::size_t num_dofs() const { return num_dofs_; }
  bool symmetric() const { return symmetric_; }
  double wave_speed() const { return wave_speed_; }  ///< of P waves [m/s]
  MPI_Comm comm() const { return comm_; }

 private:
  void finish_tangent(double dt, bool with_inertia, BlockMatrix<dim>& K);
  double end_acceleration(std::size_t dof, double du) const;
  std::unique_ptr<LinearSolver<dim>> factor_mass() const;

  /// What the cells of all ranks give for a trial state.
  struct CellSums {
    std::span<const double> internal, inertia;  // num_nodes x dim [N], in buffer_
    double energy = 0;                          // [J]
    std::string fault;                          // det F <= 0, and where; empty: nowhere
  };
  /// @pre u_trial_ is the displacement of this increment
  CellSums sum_cells(std::span<const double> du, BlockMatrix<dim>* K);

  MPI_Comm comm_;
  int rank_ = 0;
  const BoundaryConditions<dim>& conditions_;
  CellIntegrals<dim> cells_;
  NewmarkBossak scheme_;
  std::size_t num_dofs_ = 0;
  bool symmetric_ = true;
  double wave_speed_ = 0;
  std::vector<char> constrained_;  // by dof

  const StructureMotion* motion_n_ = nullptr;
  std::vector<double> f_ext_;  // with the share of the forces at the start of the step
  double dt_ = 0;
  bool with_inertia_ = false;
  NodalForces forces_;
  std::vector<double> u_trial_, a_mean_, buffer_;
  TangentPoint last_tangent_;
  std::unique_ptr<LinearSolver<dim>> mass_;  // after the first acceleration_of()
};

}  // namespace gabion::fem
