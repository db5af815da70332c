// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/base/timer.hpp"
#include "common/mechanics/newton/newton_settings.hpp"
#include "common/mechanics/petsc/block_matrix.hpp"
#include "common/mechanics/petsc/linear_solver.hpp"
#include "common/mechanics/ranks/shared_nodes.hpp"

namespace gabion {

/// Result of the evaluation of a trial state, the same on all ranks.
struct Evaluation {
  /// The state is possible (such as det(1 + H) > 0 at every point) and everything is finite.
  bool admissible = true;
  /// Scale of |r|: the largest norm of the forces that balance each other in r.
  double force_scale = 0;
  /// |r|, where the problem knows it.
  std::optional<double> residual_norm{};
  /// One step with this K likely suffices: no K is wanted with the residual after it.
  bool likely_last = false;
  std::string reason;  ///< worst place when not admissible
};

/// Equations r(du) = 0 for the increments of the unknowns, such as f_ext - f_int - f_inertia for
/// displacements; constrained directions zero. Vectors are num_nodes x block_size, of the nodes of
/// this rank.
/// @tparam block_size  number of unknowns of a node, as of BlockMatrix
template <int block_size>
class NewtonProblem {
 public:
  virtual ~NewtonProblem() = default;
  /// Sharing of the nodes of the vectors between ranks; by default each rank has all nodes.
  virtual const SharedNodes& shared() const {
    static const SharedNodes every_rank_has_all;
    return every_rank_has_all;
  }
  /// @param K  null, or filled with -dr/du (set_zero, add, constrain)
  virtual Evaluation evaluate(std::span<const double> du, std::span<double> r,
                              BlockMatrix<block_size>* K) = 0;
  /// Let K hold `share` of a full stiffness besides -dr/du where r has kinks; 0: -dr/du
  /// alone. The share holds until the next call.
  /// Collective. @returns whether there is such a place
  virtual bool regularise(double share) {
    static_cast<void>(share);
    return false;
  }
  /// Let K hold a little stiffness everywhere besides -dr/du, for parts that nothing holds as yet,
  /// such as soil before it rests on a surface; until it is called with false.
  /// @returns whether there can be such parts, the same on all ranks
  virtual bool support(bool on) {
    static_cast<void>(on);
    return false;
  }
  /// Scale of the norm of a node's block_size increments, in their unit: a cell size [m] for
  /// displacements. Unknowns of several units have to be scaled to one.
  virtual double increment_scale() const = 0;
  /// Words for node i of the vectors, for messages: where a person finds it.
  virtual std::string describe_node(std::size_t i) const { return "node " + std::to_string(i); }
  /// Words for the place inside that du strains most, for messages; empty: none. Collective.
  virtual std::string describe_worst_point(std::span<const double> du) const {
    static_cast<void>(du);
    return {};
  }
};

/// The matrix of a solve and who solves with it.
template <int block_size>
struct NewtonMatrix {
  BlockMatrix<block_size>& K;  ///< matrix with its pattern; the values are overwritten
  LinearSolver<block_size>& linear;
  /// Whether `linear` holds the matrix (and its factor) of an earlier solve that may serve again
  /// (`reuse_matrix`). The caller sets this to false when pattern, dt, constraints or method
  /// changed; solve_newton sets it for the next solve, to false when this one failed.
  bool is_usable = false;
};

struct NewtonReport {
  int iterations = 0;  ///< linear systems solved
  int matrices = 0;    ///< evaluations of K
  std::int64_t linear_iterations = 0;
  int line_search_cuts = 0;
  int regularised = 0;            ///< linear systems solved with regularisation
  int supported = 0;              ///< linear systems that had no solution without support
  std::vector<double> residuals;  ///< |r| / force_scale of each iterate
};

/// Newton's method from the guess `du` (which satisfies the constraints).
///
///     K step = r(du) ,   du <- du + s step ,   s = 1, 1/2, ..., 1/256
///
/// s is the first for which the trial state is admissible and |step . r(s)| <= 0.8 |step . r(0)| or
/// |r| falls (or |r| is within the tolerance). Converged when |r| <= residual_tolerance
/// * force_scale and the largest |s step| of a node in the last iteration <= increment_tolerance *
/// increment_scale; a guess that satisfies the first is a solution already, with 0 iterations. A
/// step within both limits that leads out of the first, as over a kink, is not taken: the iterate
/// before it is the solution. With force_scale 0 only r = 0 converges.
///
/// At kinks of r, such as soil that loses contact, s may be refused at any size and full steps
/// may jump to and fro for ever. Then K is regularised there (NewtonProblem::regularise,
/// Regularisation): s counts as good up to twice |r|, and only a step without regularisation ends
/// the search. Within the limit of |r| the regularisation is taken off. It changes K alone: the
/// solution does not depend on it. Where K without it is singular, it gets additional stiffness for
/// one step (NewtonProblem::support).
///
/// K comes with the residual in one evaluation unless the iterate is likely the last one: quadratic
/// convergence predicts it, or the problem does. The linear tolerance is 0.3 of what the next
/// residual has to reach, not looser than 1e-2 and not tighter than the linear solver's setting.
///
/// @param[in,out] matrix  -dr/du; `is_usable` lets `reuse_matrix` reach from one call to the next
/// @param[in,out] du      guess, then solution                               num_nodes x block_size
/// @param[in,out] times   "assembly" (evaluations) and "solve" (linear systems)
/// @throws UnbalancedError  iteration limit, line search failed, guess inadmissible, linear solver
///                          failed, or residual not finite; the message names the worst node and
///                          point and lists |r| / force_scale, `cause()` is "iteration_limit",
///                          "line_search", "inadmissible_guess" or "linear_solver". `du` is then
///                          the last iterate.
/// @note Collective.
/// @see Dembo, Eisenstat, Steihaug (1982) for inexact steps; Matthies, Strang (1979) for the energy
///      criterion of the line search
template <int block_size>
NewtonReport solve_newton(NewtonProblem<block_size>& problem, NewtonMatrix<block_size>& matrix,
                          const NewtonSettings& settings, std::span<double> du, PhaseTimes& times);

}  // namespace gabion
