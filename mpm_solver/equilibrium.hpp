// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <vector>

#include "common/mechanics/newton/newton.hpp"
#include "common/mechanics/time_integration/newmark.hpp"
#include "mpm_solver/basis.hpp"
#include "mpm_solver/coupling_boundary.hpp"
#include "mpm_solver/grid_nodes.hpp"
#include "mpm_solver/wall_conditions.hpp"

namespace gabion::mpm {

/// State of the material points at the end of a step that is being solved, by entry of PointWeights.
template <int dim>
struct TrialPoints {
  std::vector<MaterialState<dim>> history;
  std::vector<Symmetric<dim>> tau;
  std::vector<double> J_ratio;  ///< det(1 + H) of the step
  std::vector<double> energy;
  void resize(std::size_t n) {
    history.resize(n);
    tau.resize(n);
    J_ratio.resize(n);
    energy.resize(n);
  }
};

/// Balance of momentum of the active nodes at the end of a step,
///
///     r_i = m_i g - sum_p V0_p P_p grad N_ip - m_i [(1 - alpha_B) a'_i + alpha_B a_i] + f_contact,i
///
/// with P the first Piola-Kirchhoff stress relative to the configuration at the start of the step.
/// Refers to the parts of a solver; valid for one step.
template <int dim>
class Equilibrium final : public NewtonProblem<dim> {
 public:
  struct Parts {
    MPI_Comm comm;
    const BackgroundGrid<dim>& grid;
    const std::vector<Body<dim>>& bodies;
    const MaterialPoints<dim>& points;
    const PointWeights<dim>& weights;
    const GridNodes<dim>& nodes;
    const WallConditions<dim>& walls;
    std::vector<CouplingBoundary<dim>>& boundaries;
    TrialPoints<dim>& trial;
    const NewmarkBossak& scheme;
    Vector<dim> gravity;
    double cell_size;
    double dt;
  };
  explicit Equilibrium(const Parts& parts);

  Evaluation evaluate(std::span<const double> du, std::span<double> r,
                      BlockMatrix<dim>* K) override;
  /// A new solution with other interface values begins: its first evaluation may take the tangent
  /// of the stresses from the neighbouring state where the last solution left it.
  void begin_solution() { first_evaluation_ = true; }
  double length_scale() const override { return parts_.cell_size; }

  /// Forget the tangent of earlier solutions, so that repeated requests give the same bits.
  void forget_tangent() { du_K_.clear(); }

  /// Cells of the matrix pattern, as lists of active nodes: cells with points of this rank, then
  /// the cells of boundary points.
  void pattern(std::vector<std::int32_t>& offsets, std::vector<std::int32_t>& nodes) const;

  /// Nodal velocity at the start of the step with the wall conditions, num_nodes x dim.
  const std::vector<double>& start_velocity() const { return v_; }
  const std::vector<double>& start_acceleration() const { return a_; }

 private:
  /// f_int of this rank's points and, with K, its derivative. What does not depend on the interface
  /// is kept: a coupling iteration starts from the du of the last one, whose stresses are known.
  bool internal_forces(std::span<const double> du, BlockMatrix<dim>* K, std::int32_t& worst);
  template <class Law>
  bool body_forces(const Law& law, std::int32_t body, std::span<const double> du,
                   std::span<double> f_int, BlockMatrix<dim>* K, std::int32_t& worst);
  double add_body_forces(std::span<const double> du, std::span<double> r,
                         BlockMatrix<dim>* K) const;

  Parts parts_;
  std::vector<double> v_, a_;     // walls applied
  std::vector<double> inertia_m_; // mass with the floor for nearly weightless nodes
  std::vector<double> f_int_;     // of this rank's points at du_known_
  std::vector<double> f_sum_;     // of all ranks
  std::vector<double> du_known_;  // where the stresses were last evaluated; empty: nowhere
  std::vector<double> du_K_;      // where K_int_ was evaluated; empty: nowhere
  std::vector<double> K_int_;     // values of the matrix: derivative of f_int alone
  bool first_evaluation_ = true;
};

}  // namespace gabion::mpm
