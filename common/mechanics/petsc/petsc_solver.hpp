// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <cstdint>

#include "common/mechanics/petsc/linear_method.hpp"
#include "common/mechanics/petsc/petsc_handle.hpp"

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
  void invalidate(bool new_pattern);

  struct Result {
    bool converged = false;
    int iterations = 0;
    const char* reason = "";  ///< PETSc's word for how it ended
  };
  /// Solve matrix x = b from x = 0.
  /// @note Collective.
  Result solve(Mat matrix, Vec b, Vec x, double tolerance);

  std::int64_t set_ups() const { return set_ups_; }

 private:
  void configure_preconditioner();
  void set_up(Mat matrix);

  MPI_Comm comm_;
  int dim_;
  LinearMethod method_;
  int max_iterations_ = 0;
  KspHandle ksp_;
  bool is_set_up_ = false;
  bool new_pattern_ = true;
  std::int64_t set_ups_ = 0;
};

}  // namespace gabion
