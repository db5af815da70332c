// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <vector>

#include "common/base/config_reader.hpp"
#include "common/base/timer.hpp"
#include "common/mechanics/petsc/block_matrix.hpp"
#include "common/mechanics/petsc/linear_solver.hpp"

namespace gabion {

/// The "newton" object of a solver's config.
struct NewtonSettings {
  double residual_tolerance = 1e-8;   ///< |r| <= tol * scale of the forces
  double increment_tolerance = 1e-8;  ///< max |step| <= tol * length
  int max_iterations = 20;
  /// Keep the matrix (and its factor) while |r| falls by more than a factor 4 an iteration.
  bool reuse_matrix = false;
};
NewtonSettings read_newton_settings(ConfigReader in, NewtonSettings defaults = {});

/// Forces of a trial state.
struct Evaluation {
  bool admissible = true;    ///< det(1 + H) > 0 at every point, everything finite
  double force_scale = 0;    ///< max(|f_int|, |f_ext|, |f_inertia|), what |r| is compared with
  std::string reason;        ///< worst point when not admissible
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
};

struct NewtonReport {
  int iterations = 0;
  std::int64_t linear_iterations = 0;
  int line_search_cuts = 0;
  std::vector<double> residuals;  ///< |r| / force_scale of each iterate
};

/// Newton's method from the guess `du` (which satisfies the constraints). The step is halved until
/// the trial state is admissible and |step . r(s)| <= 0.8 |step . r(0)| or |r| falls.
/// @throws ConvergenceError  iteration limit, line search failed, or residual not finite; the
///                           message names the worst node or point
template <int dim>
NewtonReport solve_newton(NewtonProblem<dim>& problem, BlockMatrix<dim>& K, bool new_pattern,
                          LinearSolver<dim>& linear, const NewtonSettings& settings,
                          std::span<double> du, PhaseTimes& times);

}  // namespace gabion
