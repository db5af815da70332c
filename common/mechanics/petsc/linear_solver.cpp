// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/petsc/linear_solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "common/mechanics/norm.hpp"
#include "common/mechanics/petsc/petsc_matrix.hpp"
#include "common/mechanics/petsc/petsc_solver.hpp"

namespace gabion {

namespace {

constexpr double direct_tolerance = 1e-8;

}  // namespace

template <int dim>
struct LinearSolver<dim>::Implementation {
  Implementation(MPI_Comm comm, LinearSolverSettings given)
      : settings(std::move(given)), matrix(comm), main(comm, dim), rescue(comm, dim) {
    MPI_Comm_size(comm, &num_ranks);
  }

  int solve(std::span<const double> b, std::span<double> x, double tolerance);
  /// Solve for the right-hand side that `matrix` holds; converged means by the true residual.
  PetscSolver::Result attempt(PetscSolver& solver, double b_norm, double tolerance);
  PetscSolver::Result use_rescue(SolutionMethod method, double b_norm, const char* reason);

  LinearSolverSettings settings;
  int num_ranks = 1;
  PetscMatrix<dim> matrix;
  LinearMethod chosen;
  bool is_chosen = false;
  PetscSolver main;    // with the chosen method
  PetscSolver rescue;  // direct, when the chosen method failed for this matrix
  bool use_rescue_first = false;
  std::int64_t fallbacks = 0;
};

template <int dim>
PetscSolver::Result LinearSolver<dim>::Implementation::attempt(PetscSolver& solver, double b_norm,
                                                               double tolerance) {
  Vec b = matrix.right_hand_side();
  PetscSolver::Result result = solver.solve(matrix.get(), b, matrix.solution(), tolerance);
  const bool direct = solver.method().direct();
  if (!result.converged) return result;
  const double allowed = (direct ? direct_tolerance : 10 * tolerance) * b_norm;
  // Also false for NaN.
  if (!(matrix.residual_norm() <= allowed)) {
    result.converged = false;
    result.reason = "the true residual is above the tolerance";
  }
  return result;
}

template <int dim>
PetscSolver::Result LinearSolver<dim>::Implementation::use_rescue(SolutionMethod method,
                                                                  double b_norm,
                                                                  const char* reason) {
  const LinearMethod direct{method, Preconditioner::none};
  // Once in the open; a regime in which it happens at every matrix would flood the log.
  const auto level = fallbacks <= 1 ? log::Level::warn : log::Level::debug;
  log::write(level, fmt::format("linear solver: {} failed ({}), {} for this matrix",
                                main.method().name(), reason, direct.name()));
  rescue.configure(direct, 1);
  return attempt(rescue, b_norm, direct_tolerance);
}

template <int dim>
int LinearSolver<dim>::Implementation::solve(std::span<const double> b, std::span<double> x,
                                             double tolerance) {
  const double b_norm = norm_of(b);
  require<ConvergenceError>(std::isfinite(b_norm), "linear solver: right-hand side is not finite");
  if (b_norm == 0) {
    std::fill(x.begin(), x.end(), 0.0);
    return 0;
  }
  matrix.set_right_hand_side(b);
  int iterations = 0;
  PetscSolver::Result result;
  if (use_rescue_first) {
    result = attempt(rescue, b_norm, direct_tolerance);
  } else {
    main.configure(chosen, settings.max_iterations);
    result = attempt(main, b_norm, std::max(tolerance, settings.tolerance));
    iterations = result.iterations;
    const SolutionMethod direct = choose_direct_method(dim, matrix.num_dofs(), num_ranks);
    if (!result.converged && !chosen.direct()) {
      ++fallbacks;
      use_rescue_first = true;
      result = use_rescue(direct, b_norm, result.reason);
    }
  }
  // MUMPS exchanges rows for stability, the small block LU does not.
  const LinearMethod& last = use_rescue_first ? rescue.method() : main.method();
  if (!result.converged && last.method == SolutionMethod::lu) {
    use_rescue_first = true;
    result = use_rescue(SolutionMethod::mumps, b_norm, result.reason);
  }
  require<ConvergenceError>(
      result.converged,
      "linear solver: {} failed with {} unknowns: {}; the matrix is singular, nearly so, "
      "or not finite",
      (use_rescue_first ? rescue : main).method().name(), matrix.num_dofs(), result.reason);
  matrix.replicate_solution(x);
  return iterations;
}

template <int dim>
LinearSolver<dim>::LinearSolver(MPI_Comm comm, LinearSolverSettings settings)
    : impl_(std::make_unique<Implementation>(comm, std::move(settings))) {}

template <int dim>
LinearSolver<dim>::~LinearSolver() = default;
template <int dim>
LinearSolver<dim>::LinearSolver(LinearSolver&&) noexcept = default;
template <int dim>
LinearSolver<dim>& LinearSolver<dim>::operator=(LinearSolver&&) noexcept = default;

template <int dim>
void LinearSolver<dim>::set_regime(const LinearRegime& regime, std::int32_t num_nodes) {
  const LinearMethod method = choose_linear_method(
      impl_->settings, regime, dim, static_cast<std::int64_t>(num_nodes) * dim, impl_->num_ranks);
  if (!impl_->is_chosen || method != impl_->chosen)
    log::info("linear solver: {} for {} nodes, Courant number {:.3g}", method.name(), num_nodes,
              regime.courant);
  impl_->chosen = method;
  impl_->is_chosen = true;
}

template <int dim>
void LinearSolver<dim>::set_matrix(const BlockMatrix<dim>& K, bool new_pattern) {
  if (!impl_->is_chosen)
    set_regime({false, std::numeric_limits<double>::infinity()}, K.num_nodes());
  const bool renewed = impl_->matrix.set(K, new_pattern);
  impl_->main.invalidate(renewed);
  impl_->rescue.invalidate(renewed);
  impl_->use_rescue_first = false;
}

template <int dim>
int LinearSolver<dim>::solve(std::span<const double> b, std::span<double> x, double tolerance) {
  return impl_->solve(b, x, tolerance);
}

template <int dim>
std::optional<SolutionMethod> LinearSolver<dim>::rescue() const {
  if (!impl_->use_rescue_first) return std::nullopt;
  return impl_->rescue.method().method;
}

template <int dim>
void LinearSolver<dim>::set_rescue(std::optional<SolutionMethod> method) {
  impl_->use_rescue_first = method.has_value();
  if (method) impl_->rescue.configure({*method, Preconditioner::none}, 1);
}

template <int dim>
std::string LinearSolver<dim>::method_name() const {
  return impl_->chosen.name();
}

template <int dim>
std::int64_t LinearSolver<dim>::factorisations() const {
  return impl_->main.set_ups() + impl_->rescue.set_ups();
}

template <int dim>
std::int64_t LinearSolver<dim>::fallbacks() const {
  return impl_->fallbacks;
}

template class LinearSolver<2>;
template class LinearSolver<3>;

}  // namespace gabion
