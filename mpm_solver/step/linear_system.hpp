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
  LinearSystem(MPI_Comm comm, const LinearSolverSettings& settings)
      : solver_(comm, dim, settings) {}

  /// A step begins. @param pause  of the solver after the step before
  void begin(const Equilibrium<dim>& equilibrium, const LinearRegime& regime,
             const KrylovPause& pause) {
    std::vector<std::int32_t> offsets, cell_nodes;
    equilibrium.pattern(offsets, cell_nodes);
    const std::vector<Vector<dim>>& positions = equilibrium.parts().nodes.x;
    const auto num_nodes = static_cast<std::int32_t>(positions.size());
    std::vector<double> x;
    x.reserve(positions.size() * dim);
    for (const Vector<dim>& node : positions) x.insert(x.end(), node.begin(), node.end());
    solver_.set_coordinates(std::move(x));
    solver_.begin_step(pause);
    K_.set_pattern(num_nodes, offsets, cell_nodes);
    solver_.set_regime(regime, num_nodes);
  }
  BlockMatrix<dim>& K() { return K_; }
  /// K x = r. @returns number of linear iterations
  std::int64_t solve(std::span<const double> r, std::span<double> x) {
    solver_.set_matrix(K_);
    return solver_.solve(r, x);
  }
  /// @param du  the guess, then the solution
  NewtonReport solve_newton(Equilibrium<dim>& equilibrium, const NewtonSettings& settings,
                            std::span<double> du, PhaseTimes& times) {
    NewtonMatrix<dim> matrix{K_, solver_};
    return gabion::solve_newton<dim>(equilibrium, matrix, settings, du, times);
  }
  const LinearSolver<dim>& solver() const { return solver_; }

 private:
  BlockMatrix<dim> K_;
  LinearSolver<dim> solver_;
};

}  // namespace gabion::mpm
