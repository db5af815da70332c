// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "common/base/config_reader.hpp"
#include "common/mechanics/petsc/block_matrix.hpp"

namespace gabion {

/// The "linear_solver" object of a solver's config.
struct LinearSolverSettings {
  /// "auto" | "lu" | "mumps" | "bicgstab" | "gmres" | "cg"
  std::string method = "auto";
  /// "auto" | "jacobi" (node blocks) | "ilu" ; for Krylov methods
  std::string preconditioner = "auto";
  double tolerance = 1e-8;  ///< on the true residual, relative to the right-hand side
  int max_iterations = 500;
};
LinearSolverSettings read_linear_solver_settings(ConfigReader in);

/// What "auto" needs to know.
struct LinearRegime {
  bool symmetric = false;
  /// Elastic Courant number c dt / h; infinity for statics. Mass dominates the matrix when small.
  double courant = 0;
};

/// Solves K x = b with PETSc. b and x are replicated: every rank holds the whole vector.
template <int dim>
class LinearSolver {
 public:
  LinearSolver(MPI_Comm comm, LinearSolverSettings settings);
  ~LinearSolver();
  LinearSolver(const LinearSolver&) = delete;
  LinearSolver& operator=(const LinearSolver&) = delete;
  LinearSolver(LinearSolver&&) noexcept;
  LinearSolver& operator=(LinearSolver&&) noexcept;

  /// Choose the method for this regime and size (logged when it changes).
  void set_regime(const LinearRegime& regime, std::int32_t num_nodes);

  /// Take over new values of K. A direct method factorises at the next solve.
  void set_matrix(const BlockMatrix<dim>& K, bool new_pattern);

  /// Solve with the matrix of the last set_matrix. A Krylov method that fails is replaced by the
  /// direct one for this matrix (logged, counted).
  /// @param tolerance  relative to |b|; <= 0 takes the setting
  /// @returns iterations (0 for a direct solve)
  /// @throws ConvergenceError  neither worked
  /// @note Collective.
  int solve(std::span<const double> b, std::span<double> x, double tolerance = -1);

  std::string method_name() const;       ///< such as "bicgstab + node-block jacobi"
  std::int64_t factorisations() const;
  std::int64_t fallbacks() const;        ///< Krylov solves that went to the direct method

 private:
  struct Implementation;
  std::unique_ptr<Implementation> impl_;
};

}  // namespace gabion
