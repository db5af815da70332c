// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/petsc/linear_solver.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "common/mechanics/petsc/petsc_matrix.hpp"
#include "common/mechanics/petsc/petsc_solver.hpp"

namespace gabion {

namespace {

constexpr double direct_tolerance = 1e-8;

// Tolerance of the last method where round-off is accepted: a singular matrix leaves nearly all
// of b.
constexpr double round_off_tolerance = 1e-5;

// The residual that a Krylov method carries along is the true one but for rounding of some 1e-16
// an iteration: up to these bounds it needs no check.
constexpr int trusted_iterations = 100;
constexpr double trusted_tolerance = 1e-10;

std::string regime_text(double courant) {
  if (courant == 0) return "of the mass matrix";
  return std::isinf(courant) ? "without inertia" : fmt::format("Courant number {:.3g}", courant);
}

}  // namespace

template <int block_size>
struct LinearSolver<block_size>::Implementation {
  Implementation(MPI_Comm comm, int dim_of_space, LinearSolverSettings given)
      : settings(std::move(given)),
        dim(dim_of_space),
        matrix(comm),
        main(comm, dim),
        rescue(comm, dim) {
    MPI_Comm_size(comm, &num_ranks);
  }

  int solve(std::span<const double> b, std::span<double> x, double tolerance);
  /// Solve for the right-hand side that `matrix` holds; converged means by the true residual.
  PetscSolver::Result attempt(PetscSolver& solver, double b_norm, double tolerance);
  double allowed_residual(const LinearMethod& method, double tolerance) const;
  PetscSolver::Result use_main(double b_norm, double tolerance);
  SolutionMethod direct_method() const {
    return choose_direct_method(dim, matrix.num_dofs(), num_ranks);
  }
  bool rests() const {
    return !chosen.direct() && (has_failed || (pause.steps > 0 && pause.method == chosen.number()));
  }
  KrylovPause pause_after() const;
  PetscSolver::Result use_rescue(SolutionMethod method, double b_norm, const char* reason);

  LinearSolverSettings settings;
  int dim;  // dimension of the space of the nodes
  int num_ranks = 1;
  PetscMatrix<block_size> matrix;
  LinearMethod chosen;
  bool is_chosen = false;
  PetscSolver main;    // solver with the chosen method
  PetscSolver rescue;  // direct, when the chosen method failed for this matrix
  bool use_rescue_first = false;
  bool accepts_round_off = false;
  bool has_been_rescued = false;
  KrylovPause pause;                            // state at the start of the step
  bool has_failed = false, has_worked = false;  // the chosen Krylov method in this step
  std::int64_t fallbacks = 0;
};

template <int block_size>
double LinearSolver<block_size>::Implementation::allowed_residual(const LinearMethod& method,
                                                                  double tolerance) const {
  if (!method.direct()) return 10 * tolerance;
  const bool last = method.method == SolutionMethod::mumps;
  const double least = last && accepts_round_off ? round_off_tolerance : direct_tolerance;
  return std::max(least, settings.tolerance);
}

template <int block_size>
PetscSolver::Result LinearSolver<block_size>::Implementation::attempt(PetscSolver& solver,
                                                                      double b_norm,
                                                                      double tolerance) {
  Vec b = matrix.right_hand_side();
  PetscSolver::Result result = solver.solve(matrix, b, matrix.solution(), tolerance);
  const bool direct = solver.method().direct();
  if (!result.converged) return result;
  if (!direct && result.iterations <= trusted_iterations && tolerance >= trusted_tolerance) {
    return result;
  }
  const double allowed = allowed_residual(solver.method(), tolerance) * b_norm;
  // The comparison is false for NaN too.
  if (!(matrix.residual_norm() <= allowed)) {
    result.converged = false;
    result.reason = "the true residual is above the tolerance";
  }
  return result;
}

template <int block_size>
PetscSolver::Result LinearSolver<block_size>::Implementation::use_rescue(SolutionMethod method,
                                                                         double b_norm,
                                                                         const char* reason) {
  const LinearMethod direct{method, Preconditioner::none};
  const std::string how_long =
      chosen.direct() ? "matrix" : fmt::format("step and the next {}", pause_after().steps);
  // Warn once; a regime in which it happens again and again would flood the log.
  const auto level = has_been_rescued ? log::Level::debug : log::Level::warn;
  has_been_rescued = true;
  log::write(level, fmt::format("linear solver: {} failed ({}), {} for this {}",
                                main.method().name(), reason, direct.name(), how_long));
  rescue.configure(direct, 1);
  return attempt(rescue, b_norm, direct_tolerance);
}

template <int block_size>
KrylovPause LinearSolver<block_size>::Implementation::pause_after() const {
  KrylovPause after = pause;
  if (has_failed) {
    after.after_failure(chosen.number());
  } else if (has_worked) {
    after.after_success();
  } else {
    after.after_rest();
  }
  return after;
}

template <int block_size>
PetscSolver::Result LinearSolver<block_size>::Implementation::use_main(double b_norm,
                                                                       double tolerance) {
  main.configure(chosen, settings.max_iterations);
  PetscSolver::Result result = attempt(main, b_norm, tolerance);
  has_worked = has_worked || (result.converged && !chosen.direct());
  return result;
}

template <int block_size>
int LinearSolver<block_size>::Implementation::solve(std::span<const double> b, std::span<double> x,
                                                    double tolerance) {
  const double b_norm = matrix.shared().norm(b);
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
    result = use_main(b_norm, std::max(tolerance, settings.tolerance));
    iterations = result.iterations;
    if (!result.converged && !chosen.direct()) {
      ++fallbacks;
      has_failed = use_rescue_first = true;
      result = use_rescue(direct_method(), b_norm, result.reason);
    }
  }
  // MUMPS exchanges rows for stability, the small block LU does not.
  const LinearMethod& last = use_rescue_first ? rescue.method() : main.method();
  if (!result.converged && last.method == SolutionMethod::lu) {
    use_rescue_first = true;
    result = use_rescue(SolutionMethod::mumps, b_norm, result.reason);
  }
  // The matrix is at fault, not the method.
  has_failed = has_failed && result.converged;
  require<ConvergenceError>(
      result.converged,
      "linear solver: {} failed with {} unknowns: {}; the matrix is singular, nearly so, "
      "or not finite",
      (use_rescue_first ? rescue : main).method().name(), matrix.num_dofs(), result.reason);
  matrix.take_solution(x);
  return iterations;
}

template <int block_size>
LinearSolver<block_size>::LinearSolver(MPI_Comm comm, int dim, LinearSolverSettings settings)
    : impl_(std::make_unique<Implementation>(comm, dim, std::move(settings))) {}

template <int block_size>
LinearSolver<block_size>::~LinearSolver() = default;
template <int block_size>
LinearSolver<block_size>::LinearSolver(LinearSolver&&) noexcept = default;
template <int block_size>
LinearSolver<block_size>& LinearSolver<block_size>::operator=(LinearSolver&&) noexcept = default;

template <int block_size>
void LinearSolver<block_size>::accept_round_off() {
  impl_->accepts_round_off = true;
}

template <int block_size>
void LinearSolver<block_size>::begin_step(const KrylovPause& pause) {
  impl_->pause = pause;
  impl_->has_failed = impl_->has_worked = false;
  impl_->main.begin_step();
}

template <int block_size>
KrylovPause LinearSolver<block_size>::pause() const {
  return impl_->pause_after();
}

template <int block_size>
void LinearSolver<block_size>::set_coordinates(std::vector<double> x) {
  assert(block_size == impl_->dim);
  impl_->main.set_coordinates(std::move(x));
}

template <int block_size>
void LinearSolver<block_size>::set_regime(const LinearRegime& regime, std::int64_t num_nodes) {
  const std::int64_t num_dofs = num_nodes * block_size;
  const LinearMethod method =
      choose_linear_method(impl_->settings, regime, impl_->dim, num_dofs, impl_->num_ranks);
  if (!impl_->is_chosen || method != impl_->chosen)
    log::info("linear solver: {} for {} nodes, {}", method.name(), num_nodes,
              regime_text(regime.courant));
  impl_->chosen = method;
  impl_->is_chosen = true;
}

template <int block_size>
std::span<double> LinearSolver<block_size>::make_room(const BlockMatrix<block_size>& K) {
  // A rank may be alone with its new pattern, and what was set up is released by all together.
  if (impl_->num_ranks > 1) return {};
  impl_->main.release();
  impl_->rescue.release();
  return impl_->matrix.make_room(K);
}

template <int block_size>
void LinearSolver<block_size>::release() {
  impl_->main.release();
  impl_->rescue.release();
  impl_->matrix.release();
}

template <int block_size>
void LinearSolver<block_size>::set_matrix(const BlockMatrix<block_size>& K,
                                          const SharedNodes& shared) {
  if (!impl_->is_chosen)
    set_regime({false, std::numeric_limits<double>::infinity()},
               shared.alone() ? K.num_nodes() : shared.num_of_all());
  const bool renewed = impl_->matrix.set(K, shared);
  impl_->main.invalidate(renewed);
  impl_->rescue.invalidate(renewed);
  impl_->use_rescue_first = impl_->rests();
  if (impl_->use_rescue_first) {
    impl_->rescue.configure({impl_->direct_method(), Preconditioner::none}, 1);
  }
}

template <int block_size>
int LinearSolver<block_size>::solve(std::span<const double> b, std::span<double> x,
                                    double tolerance) {
  return impl_->solve(b, x, tolerance);
}

template <int block_size>
std::optional<SolutionMethod> LinearSolver<block_size>::rescue() const {
  if (!impl_->use_rescue_first) return std::nullopt;
  return impl_->rescue.method().method;
}

template <int block_size>
void LinearSolver<block_size>::set_rescue(std::optional<SolutionMethod> method) {
  impl_->use_rescue_first = method.has_value();
  if (method) impl_->rescue.configure({*method, Preconditioner::none}, 1);
}

template <int block_size>
std::string LinearSolver<block_size>::method_name() const {
  return impl_->chosen.name();
}

template <int block_size>
std::int64_t LinearSolver<block_size>::factorisations() const {
  return impl_->main.set_ups() + impl_->rescue.set_ups();
}

template <int block_size>
std::int64_t LinearSolver<block_size>::fallbacks() const {
  return impl_->fallbacks;
}

template <int block_size>
double LinearSolver<block_size>::preconditioner_bytes() const {
  return impl_->main.factor_bytes() + impl_->rescue.factor_bytes();
}

template class LinearSolver<2>;
template class LinearSolver<3>;
template class LinearSolver<4>;

}  // namespace gabion
