// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "common/mechanics/petsc/block_matrix.hpp"
#include "common/mechanics/petsc/linear_method.hpp"
#include "common/mechanics/petsc/parts_preconditioner.hpp"
#include "common/mechanics/petsc/petsc_handle.hpp"
#include "common/mechanics/ranks/shared_nodes.hpp"

namespace gabion {

/// A matrix that stays where it was assembled, in a part of each rank: a product takes the vector
/// from the owners of its nodes, multiplies by the parts, and adds the results up at the owners.
///
/// Preconditioners: inverse diagonal blocks; or ILU(0) of the rows and columns of all nodes that a
/// rank holds, so that neighbouring ranks overlap in the nodes that they share. A rank keeps what
/// comes out at its own nodes (Cai and Sarkis, 1999, restricted additive Schwarz); with conjugate
/// gradients, which want it symmetric, the factors are of the owned nodes alone.
template <int block_size>
class MatrixParts {
 public:
  /// @param K  this rank's part, which must outlive this; its values may change
  MatrixParts(MPI_Comm comm, const BlockMatrix<block_size>& K, SharedNodes shared);
  MatrixParts(const MatrixParts&) = delete;  // PETSc refers to it
  MatrixParts& operator=(const MatrixParts&) = delete;
  MatrixParts(MatrixParts&&) = delete;
  MatrixParts& operator=(MatrixParts&&) = delete;
  ~MatrixParts() = default;

  /// Operator by which PETSc multiplies; it has the rows of the owned nodes.
  Mat get() const { return shell_.get(); }
  /// y = K x. @param x, y  num_owned x block_size
  void multiply(const double* x, double* y);
  /// Preconditioner for the present values. @note Collective.
  std::unique_ptr<PartsPreconditioner> preconditioner(const LinearMethod& method) const;

 private:
  std::unique_ptr<PartsPreconditioner> make_jacobi() const;
  std::unique_ptr<PartsPreconditioner> make_ilu(bool overlapping) const;

  const BlockMatrix<block_size>& K_;
  SharedNodes shared_;
  MatHandle shell_;
  std::vector<double> x_, y_;  // values at the held nodes
};

}  // namespace gabion
