// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/petsc/petsc_solver.hpp"

#include <algorithm>
#include <cmath>

#include "common/mechanics/petsc/petsc_session.hpp"

namespace gabion {

namespace {

// A kept preconditioner serves up to this factor of the iterations a digit that the first solve
// with it took, and some.
constexpr double growth = 1.5;
constexpr int few_iterations = 5;

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

PetscErrorCode apply_parts(PC pc, Vec r, Vec z) {
  void* context = nullptr;
  const double* from = nullptr;
  double* to = nullptr;
  PetscInt size = 0;
  PetscCall(PCShellGetContext(pc, static_cast<void*>(&context)));
  PetscCall(VecGetLocalSize(r, &size));
  PetscCall(VecGetArrayRead(r, &from));
  PetscCall(VecGetArrayWrite(z, &to));
  const auto count = static_cast<std::size_t>(size);
  static_cast<PartsPreconditioner*>(context)->apply({from, count}, {to, count});
  PetscCall(VecRestoreArrayWrite(z, &to));
  PetscCall(VecRestoreArrayRead(r, &from));
  return 0;
}

}  // namespace

void PetscSolver::configure(const LinearMethod& method, int max_iterations) {
  if (ksp_ && method == method_ && max_iterations == max_iterations_) return;
  method_ = method;
  max_iterations_ = max_iterations;
  is_set_up_ = false;
  new_pattern_ = true;
  create();
}

void PetscSolver::create() {
  check_petsc(KSPCreate(comm_, ksp_.receive()), "KSPCreate");
  check_petsc(KSPSetType(ksp_.get(), ksp_type(method_.method)), "KSPSetType");
  if (!method_.direct()) {
    check_petsc(KSPSetNormType(ksp_.get(), KSP_NORM_UNPRECONDITIONED), "KSPSetNormType");
    const PCSide side = method_.method == SolutionMethod::cg ? PC_LEFT : PC_RIGHT;
    check_petsc(KSPSetPCSide(ksp_.get(), side), "KSPSetPCSide");
  }
  if (method_.method == SolutionMethod::gmres)
    check_petsc(KSPGMRESSetRestart(ksp_.get(), 60), "KSPGMRESSetRestart");
  configure_preconditioner();
}

void PetscSolver::configure_preconditioner() {
  PC pc = nullptr;
  check_petsc(KSPGetPC(ksp_.get(), &pc), "KSPGetPC");
  if (method_.direct()) return configure_factor(pc);
  if (method_.preconditioner == Preconditioner::multigrid) return Multigrid::configure(pc);
  int size = 1;
  MPI_Comm_size(comm_, &size);
  // The default of block Jacobi on several ranks is ILU(0) of each rank's diagonal part.
  const char* ilu = size == 1 ? PCILU : PCBJACOBI;
  const bool jacobi = method_.preconditioner == Preconditioner::jacobi;
  check_petsc(PCSetType(pc, jacobi ? PCPBJACOBI : ilu), "PCSetType");
}

void PetscSolver::configure_factor(PC pc) {
  check_petsc(PCSetType(pc, PCLU), "PCSetType");
  const bool mumps = method_.method == SolutionMethod::mumps;
  check_petsc(PCFactorSetMatSolverType(pc, mumps ? MATSOLVERMUMPS : MATSOLVERPETSC),
              "PCFactorSetMatSolverType");
  if (!mumps)
    check_petsc(PCFactorSetMatOrderingType(pc, MATORDERINGAMD), "PCFactorSetMatOrderingType");
}

void PetscSolver::invalidate(bool new_pattern) {
  new_pattern_ = new_pattern_ || new_pattern;
  has_new_values_ = true;
  const bool keeps = method_.preconditioner == Preconditioner::multigrid && may_keep_;
  if (!keeps || new_pattern_) is_set_up_ = false;
}

void PetscSolver::release() {
  if (ksp_) check_petsc(KSPReset(ksp_.get()), "KSPReset");
  of_parts_.reset();
  is_set_up_ = false;
  new_pattern_ = true;
}

void PetscSolver::begin_step() {
  may_keep_ = false;
  if (has_new_values_) is_set_up_ = false;
}

void PetscSolver::set_up_parts(const PetscOperator& matrix) {
  of_parts_.reset();  // memory of the last one
  of_parts_ = matrix.preconditioner(method_);
  if (!of_parts_) return;
  PC pc = nullptr;
  check_petsc(KSPGetPC(ksp_.get(), &pc), "KSPGetPC");
  check_petsc(PCSetType(pc, PCSHELL), "PCSetType");
  check_petsc(PCShellSetContext(pc, of_parts_.get()), "PCShellSetContext");
  check_petsc(PCShellSetApply(pc, &apply_parts), "PCShellSetApply");
}

void PetscSolver::set_up(PetscOperator& matrix) {
  const bool multigrid = method_.preconditioner == Preconditioner::multigrid;
  // Levels of multigrid may have other sizes with other values, which PETSc 3.18 does not bear.
  if (multigrid && set_ups_ > 0) create();
  if (new_pattern_) check_petsc(KSPReset(ksp_.get()), "KSPReset");
  if (!method_.direct() && !multigrid) set_up_parts(matrix);
  Mat multiplied = method_.direct() ? matrix.rows() : matrix.get();
  Mat preconditioned = multigrid ? multigrid_.copy(matrix.rows(), new_pattern_) : multiplied;
  if (multigrid && method_.method == SolutionMethod::cg)
    check_petsc(MatSetOption(preconditioned, MAT_SPD, PETSC_TRUE), "MatSetOption");
  check_petsc(KSPSetReusePreconditioner(ksp_.get(), PETSC_FALSE), "KSPSetReusePreconditioner");
  check_petsc(KSPSetOperators(ksp_.get(), multiplied, preconditioned), "KSPSetOperators");
  if (new_pattern_ && method_.method == SolutionMethod::mumps) set_up_mumps();
  check_petsc(KSPSetUp(ksp_.get()), "KSPSetUp");
  is_set_up_ = true;
  may_keep_ = true;
  new_pattern_ = false;
  has_new_values_ = false;
  first_rate_ = -1;
  ++set_ups_;
}

void PetscSolver::set_up_mumps() {
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

void PetscSolver::keep_preconditioner(Mat matrix) {
  Mat old = nullptr;
  check_petsc(KSPGetOperators(ksp_.get(), nullptr, &old), "KSPGetOperators");
  check_petsc(KSPSetOperators(ksp_.get(), matrix, old), "KSPSetOperators");
  check_petsc(KSPSetReusePreconditioner(ksp_.get(), PETSC_TRUE), "KSPSetReusePreconditioner");
}

PetscSolver::Result PetscSolver::solve(PetscOperator& matrix, Vec b, Vec x, double tolerance) {
  const bool is_old = is_set_up_ && has_new_values_;
  if (!is_set_up_) set_up(matrix);
  if (is_old) keep_preconditioner(matrix.get());
  Result result = run(b, x, tolerance);
  if (is_old && !result.converged) {
    set_up(matrix);
    const int lost = result.iterations;
    result = run(b, x, tolerance);
    result.iterations += lost;
  }
  if (method_.direct()) {
    if (!result.converged) {  // MUMPS does not bear a second solution with factors that failed
      is_set_up_ = false;
      new_pattern_ = true;
    }
    return result;
  }
  const double digits = std::max(1.0, -std::log10(tolerance));
  if (first_rate_ < 0) first_rate_ = result.iterations / digits;
  if (result.iterations > growth * first_rate_ * digits + few_iterations) may_keep_ = false;
  return result;
}

double PetscSolver::factor_bytes() const {
  if (of_parts_) return of_parts_->bytes();
  const bool has_factor = method_.preconditioner == Preconditioner::ilu || method_.direct();
  int size = 1;
  MPI_Comm_size(comm_, &size);
  if (!is_set_up_ || !has_factor || size > 1 || method_.method == SolutionMethod::mumps) return 0;
  PC pc = nullptr;
  Mat factor = nullptr;
  MatInfo info;
  check_petsc(KSPGetPC(ksp_.get(), &pc), "KSPGetPC");
  check_petsc(PCFactorGetMatrix(pc, &factor), "PCFactorGetMatrix");
  check_petsc(MatGetInfo(factor, MAT_LOCAL, &info), "MatGetInfo");
  PetscInt width = 1;
  check_petsc(MatGetBlockSize(factor, &width), "MatGetBlockSize");
  return info.nz_used * (sizeof(double) + sizeof(PetscInt) / (1.0 * width * width));
}

PetscSolver::Result PetscSolver::run(Vec b, Vec x, double tolerance) {
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
