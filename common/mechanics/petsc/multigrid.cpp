// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/petsc/multigrid.hpp"

#include <algorithm>

#include "common/base/require.hpp"
#include "common/mechanics/petsc/petsc_session.hpp"

namespace gabion {

namespace {

using NullSpaceHandle = PetscHandle<MatNullSpace, MatNullSpaceDestroy>;

constexpr PetscReal dropped_edges = 0.01;  // relative to the diagonals

}  // namespace

void Multigrid::set_coordinates(std::vector<double> coordinates, int dim) {
  coordinates_ = std::move(coordinates);
  dim_ = dim;
}

void Multigrid::configure(PC pc) {
  PetscReal threshold = dropped_edges;
  check_petsc(PCSetType(pc, PCGAMG), "PCSetType");
  check_petsc(PCGAMGSetType(pc, PCGAMGAGG), "PCGAMGSetType");
  check_petsc(PCGAMGSetThreshold(pc, &threshold, 1), "PCGAMGSetThreshold");
  // Levels from an earlier matrix would make a restarted run another one.
  check_petsc(PCGAMGSetReuseInterpolation(pc, PETSC_FALSE), "PCGAMGSetReuseInterpolation");
}

Mat Multigrid::copy(Mat matrix, bool new_pattern) {
  int num_ranks = 1;
  MPI_Comm_size(PetscObjectComm(reinterpret_cast<PetscObject>(matrix)), &num_ranks);
  if (num_ranks == 1 && !new_pattern && rows_) {
    Mat same = rows_.get();
    check_petsc(MatConvert(matrix, MATAIJ, MAT_REUSE_MATRIX, &same), "MatConvert");
    return same;
  }
  // PETSc 3.18 takes a matrix of several ranks apart to convert it.
  MatHandle spare;
  if (num_ranks > 1) {
    check_petsc(MatDuplicate(matrix, MAT_COPY_VALUES, spare.receive()), "MatDuplicate");
    matrix = spare.get();
  }
  check_petsc(MatConvert(matrix, MATAIJ, MAT_INITIAL_MATRIX, rows_.receive()), "MatConvert");
  set_near_null_space();
  return rows_.get();
}

void Multigrid::set_near_null_space() {
  if (coordinates_.empty()) return;
  VecHandle positions;
  NullSpaceHandle modes;
  PetscInt begin = 0, end = 0;
  double* values = nullptr;
  check_petsc(MatCreateVecs(rows_.get(), positions.receive(), nullptr), "MatCreateVecs");
  check_petsc(VecSetBlockSize(positions.get(), dim_), "VecSetBlockSize");
  check_petsc(VecGetOwnershipRange(positions.get(), &begin, &end), "VecGetOwnershipRange");
  const auto own = static_cast<std::size_t>(end - begin);
  const bool all_given = coordinates_.size() > own;
  const auto last = static_cast<std::size_t>(all_given ? end : end - begin);
  require(last <= coordinates_.size() && (all_given || own == coordinates_.size()),
          "multigrid: {} coordinates for {} unknowns", coordinates_.size(), own);
  check_petsc(VecGetArrayWrite(positions.get(), &values), "VecGetArrayWrite");
  std::copy_n(coordinates_.begin() + static_cast<std::ptrdiff_t>(last - own), own, values);
  check_petsc(VecRestoreArrayWrite(positions.get(), &values), "VecRestoreArrayWrite");
  check_petsc(MatNullSpaceCreateRigidBody(positions.get(), modes.receive()),
              "MatNullSpaceCreateRigidBody");
  check_petsc(MatSetNearNullSpace(rows_.get(), modes.get()), "MatSetNearNullSpace");
}

}  // namespace gabion
