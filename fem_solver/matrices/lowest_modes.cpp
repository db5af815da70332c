// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/matrices/lowest_modes.hpp"

#include <slepceps.h>

#include <algorithm>
#include <cmath>

#include "common/base/require.hpp"
#include "common/mechanics/petsc/petsc_handle.hpp"
#include "common/mechanics/petsc/petsc_session.hpp"

namespace gabion::fem {

namespace {

using EpsHandle = PetscHandle<EPS, EPSDestroy>;
constexpr int small_model = 400;

/// SLEPc beside a PETSc that runs already.
class SlepcSession {
 public:
  SlepcSession() {
    check_petsc(SlepcInitialize(nullptr, nullptr, nullptr, nullptr), "SlepcInitialize");
  }
  ~SlepcSession() { SlepcFinalize(); }
  SlepcSession(const SlepcSession&) = delete;
  SlepcSession& operator=(const SlepcSession&) = delete;
  SlepcSession(SlepcSession&&) = delete;
  SlepcSession& operator=(SlepcSession&&) = delete;
};

/// PETSc's view of a symmetric matrix, whose rows are its columns. The arrays stay here.
MatHandle view_of(SparseMatrix& A) {
  A.makeCompressed();
  MatHandle view;
  const auto n = static_cast<PetscInt>(A.rows());
  check_petsc(MatCreateSeqAIJWithArrays(PETSC_COMM_SELF, n, n, A.outerIndexPtr(), A.innerIndexPtr(),
                                        A.valuePtr(), view.receive()),
              "MatCreateSeqAIJWithArrays");
  return view;
}

void choose_lapack(EPS eps, int size) {
  check_petsc(EPSSetType(eps, EPSLAPACK), "EPSSetType");
  check_petsc(EPSSetWhichEigenpairs(eps, EPS_SMALLEST_REAL), "EPSSetWhichEigenpairs");
  check_petsc(EPSSetDimensions(eps, size, PETSC_DEFAULT, PETSC_DEFAULT), "EPSSetDimensions");
}

void choose_krylov(EPS eps, int count, int size) {
  ST st = nullptr;
  KSP ksp = nullptr;
  PC pc = nullptr;
  check_petsc(EPSSetType(eps, EPSKRYLOVSCHUR), "EPSSetType");
  check_petsc(EPSSetDimensions(eps, count, PETSC_DEFAULT, PETSC_DEFAULT), "EPSSetDimensions");
  check_petsc(EPSSetTarget(eps, 0), "EPSSetTarget");
  check_petsc(EPSSetWhichEigenpairs(eps, EPS_TARGET_MAGNITUDE), "EPSSetWhichEigenpairs");
  check_petsc(EPSSetTolerances(eps, 1e-12, 1000), "EPSSetTolerances");
  check_petsc(EPSGetST(eps, &st), "EPSGetST");
  check_petsc(STSetType(st, STSINVERT), "STSetType");
  check_petsc(STGetKSP(st, &ksp), "STGetKSP");
  check_petsc(KSPSetType(ksp, KSPPREONLY), "KSPSetType");
  check_petsc(KSPGetPC(ksp, &pc), "KSPGetPC");
  check_petsc(PCSetType(pc, PCCHOLESKY), "PCSetType");
  // A fixed start vector: by default it is random.
  VecHandle start;
  check_petsc(VecCreateSeq(PETSC_COMM_SELF, size, start.receive()), "VecCreateSeq");
  check_petsc(VecSet(start.get(), 1), "VecSet");
  Vec first = start.get();
  check_petsc(EPSSetInitialSpace(eps, 1, &first), "EPSSetInitialSpace");
}

/// One mode, scaled. @throws ConvergenceError  it is none
void take_mode(const LinearModel& model, Modes& modes, int k) {
  auto shape = modes.shapes.col(k);
  Eigen::VectorXd M_shape = model.M * shape;
  Eigen::Index largest = 0;
  shape.cwiseAbs().maxCoeff(&largest);
  const double sign = shape[largest] < 0 ? -1 : 1;
  const double scale = sign / std::sqrt(shape.dot(M_shape));
  shape *= scale;
  M_shape *= scale;
  const Eigen::VectorXd force = model.K * shape;
  const double error = (force - modes.omega2[k] * M_shape).norm() / force.norm();
  require<ConvergenceError>(error < 1e-6, "mode {}: found the residual {:.2g} of its forces", k + 1,
                            error);
}

}  // namespace

Modes lowest_modes(const LinearModel& model, int count) {
  const SlepcSession slepc;
  SparseMatrix K = model.K, M = model.M;
  const MatHandle K_view = view_of(K), M_view = view_of(M);
  EpsHandle eps;
  check_petsc(EPSCreate(PETSC_COMM_SELF, eps.receive()), "EPSCreate");
  check_petsc(EPSSetOperators(eps.get(), K_view.get(), M_view.get()), "EPSSetOperators");
  check_petsc(EPSSetProblemType(eps.get(), EPS_GHEP), "EPSSetProblemType");
  if (model.size() <= small_model || 3 * count > model.size()) {
    choose_lapack(eps.get(), model.size());
  } else {
    choose_krylov(eps.get(), count, model.size());
  }
  check_petsc(EPSSolve(eps.get()), "EPSSolve");
  PetscInt found = 0;
  check_petsc(EPSGetConverged(eps.get(), &found), "EPSGetConverged");
  require<ConvergenceError>(found >= count, "found {} of {} modes", found, count);

  Modes modes{.omega2 = Eigen::VectorXd(count), .shapes = Eigen::MatrixXd(model.size(), count)};
  VecHandle shape;
  check_petsc(MatCreateVecs(K_view.get(), shape.receive(), nullptr), "MatCreateVecs");
  for (int k = 0; k < count; ++k) {
    double imaginary = 0;
    check_petsc(EPSGetEigenpair(eps.get(), k, &modes.omega2[k], &imaginary, shape.get(), nullptr),
                "EPSGetEigenpair");
    const double* values = nullptr;
    check_petsc(VecGetArrayRead(shape.get(), &values), "VecGetArrayRead");
    modes.shapes.col(k) = Eigen::Map<const Eigen::VectorXd>(values, model.size());
    check_petsc(VecRestoreArrayRead(shape.get(), &values), "VecRestoreArrayRead");
    take_mode(model, modes, k);
  }
  const auto falls = [](double low, double high) { return high < (1 - 1e-9) * low; };
  require<ConvergenceError>(
      std::adjacent_find(modes.omega2.begin(), modes.omega2.end(), falls) == modes.omega2.end(),
      "modes: found out of the order of their frequencies");
  return modes;
}

}  // namespace gabion::fem
