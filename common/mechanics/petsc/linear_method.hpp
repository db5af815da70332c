// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "common/settings/config_reader.hpp"

namespace gabion {

/// The "linear_solver" object of a solver's config.
struct LinearSolverSettings {
  /// "auto" | "lu" | "mumps" | "bicgstab" | "gmres" | "cg"
  std::string method = "auto";
  /// "auto" | "jacobi" (node blocks) | "ilu" (node blocks, no fill) | "multigrid" (smoothed
  /// aggregation); for Krylov methods
  std::string preconditioner = "auto";
  double tolerance = 1e-8;   ///< on the true residual, relative to the right-hand side; [eps, 1e-2]
  int max_iterations = 500;  ///< after these the direct method replaces a Krylov one; >= 1
};
KeyTable linear_solver_keys();
LinearSolverSettings read_linear_solver_settings(ConfigReader in);

/// Properties of a system by which "auto" chooses the method.
struct LinearRegime {
  bool symmetric = false;
  /// Elastic Courant number c dt / h; infinity for statics. Mass dominates the matrix when small.
  double courant = 0;
  /// The body bends: in space much thinner than it is long.
  bool slender = false;
  /// Rows have some hundred blocks, as those of smooth functions in space: a factor costs as much
  /// as many products.
  bool wide = false;
};

enum class SolutionMethod { lu, mumps, bicgstab, gmres, cg };
enum class Preconditioner { none, jacobi, ilu, multigrid };

/// A method to solve a linear system.
struct LinearMethod {
  SolutionMethod method = SolutionMethod::mumps;
  Preconditioner preconditioner = Preconditioner::none;

  bool direct() const { return method == SolutionMethod::lu || method == SolutionMethod::mumps; }
  std::string name() const;
  std::int64_t number() const;  ///< another one for each method
  bool operator==(const LinearMethod&) const = default;
};

/// The method that the settings ask for; "auto" takes the fastest for the regime as measured on
/// granular columns (table in linear_method.cpp).
/// @param dim       of the space of the nodes (2 or 3): how much a factor fills in
/// @param num_dofs  unknowns of the whole system
LinearMethod choose_linear_method(const LinearSolverSettings& settings, const LinearRegime& regime,
                                  int dim, std::int64_t num_dofs, int num_ranks);

/// The direct method for this size and dimension of space.
SolutionMethod choose_direct_method(int dim, std::int64_t num_dofs, int num_ranks);

}  // namespace gabion
