// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step/pressure_solver.hpp"

#include <petscksp.h>

#include <algorithm>
#include <utility>

#include "common/mechanics/petsc/petsc_handle.hpp"
#include "common/mechanics/petsc/petsc_session.hpp"

namespace gabion::mpm {

namespace {

constexpr int most_iterations = 500;

PetscErrorCode multiply(Mat matrix, Vec x, Vec y) {
  void* context = nullptr;
  const double* from = nullptr;
  double* to = nullptr;
  PetscInt size = 0;
  PetscCall(MatShellGetContext(matrix, static_cast<void*>(&context)));
  PetscCall(VecGetLocalSize(x, &size));
  PetscCall(VecGetArrayRead(x, &from));
  PetscCall(VecGetArrayWrite(y, &to));
  const auto n = static_cast<std::size_t>(size);
  (*static_cast<PressureSolver::Product*>(context))({from, n}, {to, n});
  PetscCall(VecRestoreArrayWrite(y, &to));
  PetscCall(VecRestoreArrayRead(x, &from));
  return 0;
}

}  // namespace

struct PressureSolver::Implementation {
  SparseRows near;
  Product product;
  MatHandle A, P;
  VecHandle b, x;
  KspHandle ksp;
};

PressureSolver::PressureSolver(SparseRows near, Product product)
    : impl_(std::make_unique<Implementation>()) {
  Implementation& self = *impl_;
  self.near = std::move(near);
  self.product = std::move(product);
  const auto n = static_cast<PetscInt>(self.near.starts.size()) - 1;
  check_petsc(MatCreateSeqAIJWithArrays(PETSC_COMM_SELF, n, n, self.near.starts.data(),
                                        self.near.columns.data(), self.near.values.data(),
                                        self.P.receive()),
              "MatCreateSeqAIJWithArrays");
  check_petsc(MatSetOption(self.P.get(), MAT_SPD, PETSC_TRUE), "MatSetOption");
  check_petsc(MatCreateShell(PETSC_COMM_SELF, n, n, n, n, &self.product, self.A.receive()),
              "MatCreateShell");
  check_petsc(
      MatShellSetOperation(self.A.get(), MATOP_MULT, reinterpret_cast<void (*)(void)>(&multiply)),
      "MatShellSetOperation");
  check_petsc(MatCreateVecs(self.P.get(), self.x.receive(), self.b.receive()), "MatCreateVecs");
  check_petsc(KSPCreate(PETSC_COMM_SELF, self.ksp.receive()), "KSPCreate");
  check_petsc(KSPSetType(self.ksp.get(), KSPCG), "KSPSetType");
  check_petsc(KSPSetNormType(self.ksp.get(), KSP_NORM_UNPRECONDITIONED), "KSPSetNormType");
  check_petsc(KSPSetOperators(self.ksp.get(), self.A.get(), self.P.get()), "KSPSetOperators");
  PC pc = nullptr;
  check_petsc(KSPGetPC(self.ksp.get(), &pc), "KSPGetPC");
  check_petsc(PCSetType(pc, PCICC), "PCSetType");
  check_petsc(PCFactorSetShiftType(pc, MAT_SHIFT_POSITIVE_DEFINITE), "PCFactorSetShiftType");
  check_petsc(KSPSetUp(self.ksp.get()), "KSPSetUp");
}

PressureSolver::~PressureSolver() = default;

std::optional<int> PressureSolver::solve(std::span<const double> b, std::span<double> x,
                                         double tolerance) {
  Implementation& self = *impl_;
  double* values = nullptr;
  check_petsc(VecGetArrayWrite(self.b.get(), &values), "VecGetArrayWrite");
  std::ranges::copy(b, values);
  check_petsc(VecRestoreArrayWrite(self.b.get(), &values), "VecRestoreArrayWrite");
  check_petsc(KSPSetTolerances(self.ksp.get(), tolerance, 0, PETSC_DEFAULT, most_iterations),
              "KSPSetTolerances");
  check_petsc(KSPSolve(self.ksp.get(), self.b.get(), self.x.get()), "KSPSolve");
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  PetscInt iterations = 0;
  check_petsc(KSPGetConvergedReason(self.ksp.get(), &reason), "KSPGetConvergedReason");
  check_petsc(KSPGetIterationNumber(self.ksp.get(), &iterations), "KSPGetIterationNumber");
  if (reason <= 0) return std::nullopt;
  const double* found = nullptr;
  check_petsc(VecGetArrayRead(self.x.get(), &found), "VecGetArrayRead");
  std::copy_n(found, x.size(), x.begin());
  check_petsc(VecRestoreArrayRead(self.x.get(), &found), "VecRestoreArrayRead");
  return static_cast<int>(iterations);
}

}  // namespace gabion::mpm
