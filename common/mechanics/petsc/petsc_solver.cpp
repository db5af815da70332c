// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/petsc/petsc_solver.hpp"

#include "common/mechanics/petsc/petsc_session.hpp"

namespace gabion {

namespace {

const char* ksp_type(SolutionMethod method) {
  switch (method) {
    case SolutionMethod::bicgstab:
      return KSPBCGS;
    case SolutionMethod::gmres:
      return KSPGMRES;
    case SolutionMethod::cg:
      return KSPCG;
    default:
      return KSPPREONLY;
  }
}

}  // namespace

void PetscSolver::configure(const LinearMethod& method, int max_iterations) {
  if (ksp_ && method == method_ && max_iterations == max_iterations_) return;
  method_ = method;
  max_iterations_ = max_iterations;
  is_set_up_ = false;
  new_pattern_ = true;
  check_petsc(KSPCreate(comm_, ksp_.receive()), "KSPCreate");
  check_petsc(KSPSetType(ksp_.get(), ksp_type(method.method)), "KSPSetType");
  if (!method.direct()) {
    check_petsc(KSPSetNormType(ksp_.get(), KSP_NORM_UNPRECONDITIONED), "KSPSetNormType");
    const PCSide side = method.method == SolutionMethod::cg ? PC_LEFT : PC_RIGHT;
    check_petsc(KSPSetPCSide(ksp_.get(), side), "KSPSetPCSide");
  }
  if (method.method == SolutionMethod::gmres)
    check_petsc(KSPGMRESSetRestart(ksp_.get(), 60), "KSPGMRESSetRestart");
  configure_preconditioner();
}

void PetscSolver::configure_preconditioner() {
  PC pc = nullptr;
  check_petsc(KSPGetPC(ksp_.get(), &pc), "KSPGetPC");
  if (method_.direct()) {
    check_petsc(PCSetType(pc, PCLU), "PCSetType");
    const bool mumps = method_.method == SolutionMethod::mumps;
    check_petsc(PCFactorSetMatSolverType(pc, mumps ? MATSOLVERMUMPS : MATSOLVERPETSC),
                "PCFactorSetMatSolverType");
    if (!mumps)
      check_petsc(PCFactorSetMatOrderingType(pc, MATORDERINGAMD), "PCFactorSetMatOrderingType");
    return;
  }
  int size = 1;
  MPI_Comm_size(comm_, &size);
  // On several ranks ILU(0) works on each rank's diagonal part: block Jacobi's default.
  const char* ilu = size == 1 ? PCILU : PCBJACOBI;
  const bool jacobi = method_.preconditioner == Preconditioner::jacobi;
  check_petsc(PCSetType(pc, jacobi ? PCPBJACOBI : ilu), "PCSetType");
}

void PetscSolver::invalidate(bool new_pattern) {
  is_set_up_ = false;
  new_pattern_ = new_pattern_ || new_pattern;
}

void PetscSolver::set_up(Mat matrix) {
  if (new_pattern_) check_petsc(KSPReset(ksp_.get()), "KSPReset");
  check_petsc(KSPSetOperators(ksp_.get(), matrix, matrix), "KSPSetOperators");
  if (new_pattern_ && method_.method == SolutionMethod::mumps) {
    PC pc = nullptr;
    Mat factor = nullptr;
    check_petsc(KSPGetPC(ksp_.get(), &pc), "KSPGetPC");
    check_petsc(PCFactorSetUpMatSolverType(pc), "PCFactorSetUpMatSolverType");
    check_petsc(PCFactorGetMatrix(pc, &factor), "PCFactorGetMatrix");
    // Ordering: approximate minimum fill in 2D, PORD in 3D. Work space: 50 % more than estimated.
    check_petsc(MatMumpsSetIcntl(factor, 7, dim_ == 2 ? 2 : 4), "MatMumpsSetIcntl");
    check_petsc(MatMumpsSetIcntl(factor, 14, 50), "MatMumpsSetIcntl");
    // No column permutation by values: the analysis is kept for later matrices and must not depend
    // on which one was the first. The diagonal is never zero.
    check_petsc(MatMumpsSetIcntl(factor, 6, 0), "MatMumpsSetIcntl");
  }
  check_petsc(KSPSetUp(ksp_.get()), "KSPSetUp");
  is_set_up_ = true;
  new_pattern_ = false;
  ++set_ups_;
}

PetscSolver::Result PetscSolver::solve(Mat matrix, Vec b, Vec x, double tolerance) {
  if (!is_set_up_) set_up(matrix);
  if (!method_.direct())
    check_petsc(KSPSetTolerances(ksp_.get(), tolerance, 0, 1e8, max_iterations_),
                "KSPSetTolerances");
  check_petsc(KSPSolve(ksp_.get(), b, x), "KSPSolve");
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  PetscInt iterations = 0;
  check_petsc(KSPGetConvergedReason(ksp_.get(), &reason), "KSPGetConvergedReason");
  check_petsc(KSPGetIterationNumber(ksp_.get(), &iterations), "KSPGetIterationNumber");
  return {reason > 0, method_.direct() ? 0 : static_cast<int>(iterations),
          KSPConvergedReasons[reason]};
}

}  // namespace gabion
