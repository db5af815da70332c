// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/base/timer.hpp"
#include "common/mechanics/petsc/block_matrix.hpp"
#include "common/mechanics/petsc/linear_solver.hpp"
#include "common/settings/config_reader.hpp"

namespace gabion {

/// The "newton" object of a solver's config.
struct NewtonSettings {
  double residual_tolerance = 1e-8;   ///< |r| <= tol * scale of the forces; [eps, 0.1]
  double increment_tolerance = 1e-8;  ///< max |step| <= tol * length; (0, 1]
  int max_iterations = 20;            ///< >= 1
  /// Keep the matrix (and its factor) while |r| falls by more than a factor 4 an iteration.
  bool reuse_matrix = false;
};
KeyTable newton_keys(const NewtonSettings& defaults = {});
NewtonSettings read_newton_settings(ConfigReader in);

/// Forces of a trial state. The same on all ranks.
struct Evaluation {
  bool admissible = true;  ///< det(1 + H) > 0 at every point, everything finite
  double force_scale = 0;  ///< max(|f_int|, |f_ext|, |f_inertia|), what |r| is compared with
  std::string reason;      ///< worst point when not admissible
};

/// r(du) = f_ext - f_int - f_inertia, constrained directions zero. Vectors are num_nodes x dim and
/// replicated on all ranks.
template <int dim>
class NewtonProblem {
 public:
  virtual ~NewtonProblem() = default;
  /// @param K  null, or filled with -dr/du (set_zero, add, constrain)
  virtual Evaluation evaluate(std::span<const double> du, std::span<double> r,
                              BlockMatrix<dim>* K) = 0;
  virtual double length_scale() const = 0;  ///< [m], cell size
  /// Words for node i of the vectors, for messages: where a person finds it.
  virtual std::string describe_node(std::size_t i) const { return "node " + std::to_string(i); }
  /// Words for the place inside that du strains most, for messages; empty: none. Collective.
  virtual std::string describe_worst_point(std::span<const double> du) const {
    static_cast<void>(du);
    return {};
  }
};

/// What a caller with `reuse_matrix` keeps between its solves.
struct NewtonMemory {
  /// K and the factor in the linear solver are those of an earlier solve and may serve again. The
  /// caller sets it to false when dt, the constraints or the method changed; solve_newton does when
  /// the pattern is new or a solve failed.
  bool matrix_is_usable = false;
};

struct NewtonReport {
  int iterations = 0;  ///< linear systems solved
  int matrices = 0;    ///< evaluations of K
  std::int64_t linear_iterations = 0;
  int line_search_cuts = 0;
  std::vector<double> residuals;  ///< |r| / force_scale of each iterate
};

/// Newton's method from the guess `du` (which satisfies the constraints).
///
///     K step = r(du) ,   du <- du + s step ,   s = 1, 1/2, ..., 1/256
///
/// s is the first for which the trial state is admissible and |step . r(s)| <= 0.8 |step . r(0)| or
/// |r| falls (or |r| is within the tolerance). Converged when |r| <= residual_tolerance *
/// force_scale and the largest nodal |s step| of the last iteration <= increment_tolerance *
/// length_scale; a guess that satisfies the first is a solution already, with 0 iterations. With
/// force_scale 0 only r = 0 converges.
///
/// K comes with the residual in one evaluation unless quadratic convergence predicts that the
/// iterate is the last one. The linear tolerance is 1e-2 of what the next residual has to reach,
/// not looser than 1e-3 and not tighter than the linear solver's setting.
///
/// @param[in,out] K            matrix with its pattern; values are overwritten
/// @param         new_pattern  the pattern of K is not that of the last solve
/// @param[in,out] du           guess, then solution                             num_nodes x dim
/// @param[in,out] times        "assembly" (evaluations) and "solve" (linear systems)
/// @param[in,out] memory       allows `reuse_matrix` to reuse across calls; null: within this call
/// @throws ConvergenceError  iteration limit, line search failed, guess inadmissible, linear solver
///                           failed, or residual not finite; the message names the worst node and
///                           point and lists |r| / force_scale, `cause()` is "iteration_limit",
///                           "line_search", "inadmissible_guess" or "linear_solver". `du` is then
///                           the last iterate.
/// @note Collective.
/// @see Dembo, Eisenstat, Steihaug (1982) for inexact steps; Matthies, Strang (1979) for the energy
///      criterion of the line search
template <int dim>
NewtonReport solve_newton(NewtonProblem<dim>& problem, BlockMatrix<dim>& K, bool new_pattern,
                          LinearSolver<dim>& linear, const NewtonSettings& settings,
                          std::span<double> du, PhaseTimes& times, NewtonMemory* memory = nullptr);

}  // namespace gabion
