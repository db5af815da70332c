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
      : K_(empty_matrix()), solver_(comm, dim, settings) {}
  LinearSystem(const LinearSystem&) = delete;  // K_ keeps its values in solver_
  LinearSystem& operator=(const LinearSystem&) = delete;
  LinearSystem(LinearSystem&&) = delete;
  LinearSystem& operator=(LinearSystem&&) = delete;
  ~LinearSystem() = default;

  /// Begin a step. @param pause  of the solver after the step before
  void begin(const Equilibrium<dim>& equilibrium, const LinearRegime& regime,
             const KrylovPause& pause) {
    std::vector<std::int32_t> offsets, cell_nodes;
    equilibrium.pattern(offsets, cell_nodes);
    const GridNodes<dim>& nodes = equilibrium.parts().nodes;
    if (dim == 3) solver_.set_coordinates(own_coordinates(nodes));
    solver_.begin_step(pause);
    K_.set_pattern(nodes.size(), offsets, cell_nodes);
    solver_.set_regime(regime, nodes.num_of_all());
    shared_ = nodes.shared;
  }
  /// Release the memory of the stiffness until the next step begins. @note Collective.
  void release() {
    solver_.release();
    K_ = empty_matrix();
  }
  BlockMatrix<dim>& K() { return K_; }
  const BlockMatrix<dim>& K() const { return K_; }
  /// K x = r. @returns number of linear iterations
  std::int64_t solve(std::span<const double> r, std::span<double> x) {
    solver_.set_matrix(K_, shared_);
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
  BlockMatrix<dim> empty_matrix() {
    return BlockMatrix<dim>([this](const BlockMatrix<dim>& K) { return solver_.make_room(K); });
  }
  // Coordinates of the nodes that this rank owns.
  static std::vector<double> own_coordinates(const GridNodes<dim>& nodes) {
    std::vector<double> x;
    for (std::int32_t i = 0; i < nodes.size(); ++i) {
      if (nodes.shared.owns(i)) x.insert(x.end(), nodes.x[i].begin(), nodes.x[i].end());
    }
    return x;
  }

  BlockMatrix<dim> K_;
  SharedNodes shared_;
  LinearSolver<dim> solver_;
};

}  // namespace gabion::mpm
