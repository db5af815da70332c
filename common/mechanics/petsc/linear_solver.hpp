// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/mechanics/petsc/block_matrix.hpp"
#include "common/mechanics/petsc/krylov_pause.hpp"
#include "common/mechanics/petsc/linear_method.hpp"
#include "common/mechanics/ranks/shared_nodes.hpp"

namespace gabion {

/// Solves K x = b with PETSc. b and x hold the nodes of K: all of them on every rank, or those that
/// SharedNodes names.
///
/// PETSc gets a copy of K, unless K keeps its values in the room of make_room. On several ranks
/// with SharedNodes K stays where it is, in parts, see MatrixParts; direct methods and multigrid
/// get rows that belong to the owners of the nodes. Where every rank has all nodes the ranks'
/// blocks are added up in rows that are shared out in equal contiguous parts.
/// @tparam block_size  number of unknowns of a node, as of BlockMatrix
/// @pre  destroyed before the PetscSession ends
template <int block_size>
class LinearSolver {
 public:
  /// @param dim  of the space of the nodes (2 or 3): how much a factor fills in
  LinearSolver(MPI_Comm comm, int dim, LinearSolverSettings settings);
  ~LinearSolver();
  LinearSolver(const LinearSolver&) = delete;
  LinearSolver& operator=(const LinearSolver&) = delete;
  LinearSolver(LinearSolver&&) noexcept;
  LinearSolver& operator=(LinearSolver&&) noexcept;

  /// A step begins: what was set up for matrices of earlier ones serves no longer, but for the
  /// present matrix itself, so that a step depends on its beginning alone.
  /// @param pause  what pause() said after the step before
  void begin_step(const KrylovPause& pause);
  /// Pause of the Krylov methods, which the next step has to know.
  KrylovPause pause() const;

  /// Positions of the nodes for multigrid, num_nodes x dim, of all nodes or those that this rank
  /// owns, where the unknowns are displacements.
  /// @pre  block_size is dim
  void set_coordinates(std::vector<double> x);

  /// Choose the method for this regime and size (logged when it changes). Before the first
  /// call the regime is static and unsymmetric.
  /// @param num_nodes  of all ranks
  void set_regime(const LinearRegime& regime, std::int64_t num_nodes);

  /// Room for the values of K in PETSc's own matrix, until the next pattern: set_matrix then copies
  /// nothing. What was set up for the last pattern is given up. On several ranks there is none.
  std::span<double> make_room(const BlockMatrix<block_size>& K);

  /// Release the matrix and what was set up for it until the next set_matrix or make_room; values
  /// of K that are kept in that room are lost. @note Collective.
  void release();

  /// Take over new values of K, and its pattern where its pattern_id is another than in the last
  /// call. A direct method factorises at the next solve.
  /// @param K       with `shared` nodes of several ranks: must stay as it is until the next
  ///                set_matrix or release
  /// @param shared  whose the nodes of K are; the default: every rank has all
  /// @note Collective.
  void set_matrix(const BlockMatrix<block_size>& K, const SharedNodes& shared = {});

  /// Take a solution of the last direct method whose residual is at most 1e-5 |b|: where
  /// stiffnesses differ by more than 1e8 round-off alone is above 1e-8 |b|.
  /// @pre  the caller checks solutions by a residual of its own, as Newton's method does
  void accept_round_off();

  /// Solve with the matrix of the last set_matrix. A Krylov method that fails is replaced by the
  /// direct one for the rest of the step and some more, see KrylovPause (logged, counted). The
  /// residual |b - K x| of what is returned is at most 10 times the tolerance (direct: 1e-8, see
  /// accept_round_off) times |b|.
  /// @param tolerance  relative to |b|, for a looser solution than the setting asks for; a tighter
  ///                   one than the setting is not given
  /// @returns iterations (0 for a direct solve)
  /// @throws ConvergenceError  neither worked, or b, K are not finite
  /// @note Collective.
  int solve(std::span<const double> b, std::span<double> x, double tolerance = 0);

  /// The direct method that has the present matrix because the chosen one failed for it.
  std::optional<SolutionMethod> rescue() const;
  /// Give the present matrix to this method, or back to the chosen one: what rescue() said for it
  /// earlier.
  void set_rescue(std::optional<SolutionMethod> method);

  std::string method_name() const;      ///< such as "bicgstab + node-block jacobi"
  std::int64_t factorisations() const;  ///< set-ups of a factor or a preconditioner
  std::int64_t fallbacks() const;       ///< Krylov solves that went to the direct method
  double preconditioner_bytes() const;  ///< PetscSolver::factor_bytes of what this rank set up

 private:
  struct Implementation;
  std::unique_ptr<Implementation> impl_;
};

}  // namespace gabion
