// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>

#include "common/mechanics/petsc/block_matrix.hpp"
#include "common/mechanics/petsc/petsc_handle.hpp"

namespace gabion {

/// A BlockMatrix as PETSc sees it, with vectors that fit.
template <int block_size>
class PetscMatrix {
 public:
  explicit PetscMatrix(MPI_Comm comm);

  /// Take a copy of K; on several ranks the sum over the ranks.
  /// @returns true when the pattern is new and PETSc's matrix is another object than before
  /// @note Collective.
  bool set(const BlockMatrix<block_size>& K);

  Mat get() const { return matrix_.get(); }
  std::int64_t num_dofs() const { return static_cast<std::int64_t>(num_nodes_) * block_size; }

  /// Vectors: right-hand side (filled from the replicated b), solution, residual.
  void set_right_hand_side(std::span<const double> b);
  Vec right_hand_side() const { return b_.get(); }
  Vec solution() const { return x_.get(); }
  /// |b - K x| of the vectors above.
  double residual_norm();
  /// Copy the solution to every rank's x.
  void replicate_solution(std::span<double> x) const;

 private:
  void create(const BlockMatrix<block_size>& K);
  void create_alone(const BlockMatrix<block_size>& K);
  void create_shared(const BlockMatrix<block_size>& K);
  void share_out_rows();
  void insert_blocks(const BlockMatrix<block_size>& K, bool all_blocks);
  void insert_row(const BlockMatrix<block_size>& K, std::int32_t i, bool is_own);
  void copy_values(const BlockMatrix<block_size>& K);
  void assemble();

  MPI_Comm comm_;
  int rank_ = 0;
  int size_ = 1;
  std::int32_t num_nodes_ = 0;
  std::int64_t pattern_id_ = 0;
  std::vector<int> counts_, starts_;  // dofs of each rank
  MatHandle matrix_;
  VecHandle b_, x_, r_;
};

}  // namespace gabion
