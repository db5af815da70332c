// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/base/timer.hpp"
#include "common/mechanics/newton/newton.hpp"
#include "common/mechanics/petsc/linear_solver.hpp"
#include "mpm_solver/step/equilibrium.hpp"

namespace gabion::mpm {

/// The stiffness of a step and its solver.
template <int dim>
class LinearSystem {
 public:
  LinearSystem(MPI_Comm comm, const LinearSolverSettings& settings) : solver_(comm, settings) {}

  /// A step begins.
  void begin(const Equilibrium<dim>& equilibrium, const LinearRegime& regime) {
    std::vector<std::int32_t> offsets, cell_nodes;
    equilibrium.pattern(offsets, cell_nodes);
    const std::int32_t num_nodes = equilibrium.parts().nodes.size();
    K_.set_pattern(num_nodes, offsets, cell_nodes);
    new_pattern_ = true;
    solver_.set_regime(regime, num_nodes);
  }
  BlockMatrix<dim>& K() { return K_; }
  /// K x = r. @returns number of linear iterations
  std::int64_t solve(std::span<const double> r, std::span<double> x) {
    solver_.set_matrix(K_, new_pattern_);
    new_pattern_ = false;
    return solver_.solve(r, x);
  }
  /// @param du  the guess, then the solution
  NewtonReport solve_newton(Equilibrium<dim>& equilibrium, const NewtonSettings& settings,
                            std::span<double> du, PhaseTimes& times) {
    const NewtonReport report =
        gabion::solve_newton(equilibrium, K_, new_pattern_, solver_, settings, du, times);
    new_pattern_ = false;
    return report;
  }
  const LinearSolver<dim>& solver() const { return solver_; }

 private:
  BlockMatrix<dim> K_;
  LinearSolver<dim> solver_;
  bool new_pattern_ = true;
};

}  // namespace gabion::mpm
