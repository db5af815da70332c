// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "common/mechanics/petsc/linear_method.hpp"
#include "common/mechanics/petsc/multigrid.hpp"
#include "common/mechanics/petsc/petsc_handle.hpp"
#include "common/mechanics/petsc/petsc_operator.hpp"

namespace gabion {

/// One PETSc KSP with its preconditioner, set up for one LinearMethod and kept between matrices.
class PetscSolver {
 public:
  /// @param dim  of the space of the nodes (2 or 3), for the choice of orderings
  PetscSolver(MPI_Comm comm, int dim) : comm_(comm), dim_(dim) {}

  const LinearMethod& method() const { return method_; }
  /// Make this the method; a no-op when it is already.
  void configure(const LinearMethod& method, int max_iterations);

  /// The values of `matrix` are new (pattern too, if so); set-up happens at the next solve.
  /// Multigrid continues with a matrix of the same pattern while it serves: until a solve takes 5
  /// iterations more than 1.5 times those of the first one with it, by digit of the tolerance.
  void invalidate(bool new_pattern);
  /// Release what was set up, and the matrix that it was set up for.
  void release();
  /// Earlier matrices serve no longer, but the present one may stay in use.
  void begin_step();

  /// Positions of the nodes for multigrid, see Multigrid.
  void set_coordinates(std::vector<double> x) { multigrid_.set_coordinates(std::move(x), dim_); }

  struct Result {
    bool converged = false;
    int iterations = 0;
    const char* reason = "";  ///< PETSc's word for how it ended
  };
  /// Solve matrix x = b from x = 0.
  /// @note Collective.
  Result solve(PetscOperator& matrix, Vec b, Vec x, double tolerance);

  std::int64_t set_ups() const { return set_ups_; }
  /// Memory of what is set up for a matrix in parts, or of PETSc's factor on one rank; 0 without
  /// one, for MUMPS and multigrid.
  double factor_bytes() const;

 private:
  void create();
  void configure_preconditioner();
  void configure_factor(PC pc);
  void set_up(PetscOperator& matrix);
  void set_up_parts(const PetscOperator& matrix);
  void set_up_mumps();
  void keep_preconditioner(Mat matrix);
  Result run(Vec b, Vec x, double tolerance);

  MPI_Comm comm_;
  int dim_;
  LinearMethod method_;
  int max_iterations_ = 0;
  std::unique_ptr<PartsPreconditioner> of_parts_;  // what ksp_ refers to, if the matrix has parts
  KspHandle ksp_;
  Multigrid multigrid_;
  bool is_set_up_ = false;
  bool may_keep_ = false;        // what was set up serves for other values too
  bool has_new_values_ = false;  // since the set-up
  double first_rate_ = -1;       // iterations a digit of the first solve after it; -1: none yet
  bool new_pattern_ = true;
  std::int64_t set_ups_ = 0;
};

}  // namespace gabion
