// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/step/full_steps.hpp"

#include "common/base/require.hpp"
#include "fem_solver/step/kept_factor.hpp"

namespace gabion::fem {

namespace {

constexpr int most_full_steps = 20;
constexpr double close_residual = 1e-5;  // of the forces, where the line search takes over

}  // namespace

template <int dim>
int take_full_steps(Equilibrium<dim>& equilibrium, BlockMatrix<dim>& K, LinearSolver<dim>& linear,
                    std::vector<double>& du) {
  const std::vector<double> guess = du;
  std::vector<double> r(du.size()), step(du.size());
  for (int k = 0; k < most_full_steps; ++k) {
    const Evaluation now = equilibrium.evaluate(du, r, &K);
    if (!now.admissible) break;
    if (*now.residual_norm <= close_residual * now.force_scale) return k;
    try {
      linear.set_matrix(K, equilibrium.shared());
      linear.solve(r, step);
    } catch (const ConvergenceError&) {
      break;
    }
    for (std::size_t i = 0; i < du.size(); ++i) du[i] += step[i];
  }
  du = guess;
  return 0;
}

template <int dim>
LinearSolverSettings full_step_solver(const FemSettings<dim>& settings) {
  auto linear = with_kept_factor<dim>(settings.linear_solver, settings.mesh, settings.ranks,
                                      settings.dynamic);
  if (settings.beam_nodes().any() && linear.method == "auto") linear.method = "mumps";
  return linear;
}

template int take_full_steps(Equilibrium<2>&, BlockMatrix<2>&, LinearSolver<2>&,
                             std::vector<double>&);
template int take_full_steps(Equilibrium<3>&, BlockMatrix<3>&, LinearSolver<3>&,
                             std::vector<double>&);
template LinearSolverSettings full_step_solver(const FemSettings<2>&);
template LinearSolverSettings full_step_solver(const FemSettings<3>&);

}  // namespace gabion::fem
