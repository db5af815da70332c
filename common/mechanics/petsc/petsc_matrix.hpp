// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/mechanics/petsc/block_matrix.hpp"
#include "common/mechanics/petsc/matrix_parts.hpp"
#include "common/mechanics/petsc/petsc_handle.hpp"
#include "common/mechanics/petsc/petsc_operator.hpp"
#include "common/mechanics/ranks/packet.hpp"
#include "common/mechanics/ranks/shared_nodes.hpp"

namespace gabion {

/// A BlockMatrix as PETSc sees it, with vectors that fit. Where ranks hold nodes of their own each
/// keeps its part, see MatrixParts; rows are made when a method wants entries.
template <int block_size>
class PetscMatrix final : public PetscOperator {
 public:
  explicit PetscMatrix(MPI_Comm comm);

  /// A new matrix with the pattern of K, and the memory of its values, where K may keep its own:
  /// `set` then has nothing to copy. @pre one rank; several exchange blocks
  std::span<double> make_room(const BlockMatrix<block_size>& K);

  /// Take a copy of K; on several ranks the sum over the ranks, and where ranks hold nodes of their
  /// own not a copy: K must stay as it is until the next `set` or `release`.
  /// @param shared  whose the nodes of K are; alone() on several ranks: every rank has all
  /// @returns true when the pattern is new and PETSc's matrix is another object than before
  /// @note Collective.
  bool set(const BlockMatrix<block_size>& K, const SharedNodes& shared);

  /// Release the matrix, its vectors and their memory. @note Collective.
  void release() {
    matrix_.reset();
    parts_.reset();
    K_ = nullptr;
    for (VecHandle* vector : {&x_, &b_, &r_}) vector->reset();
  }

  const SharedNodes& shared() const { return shared_; }
  Mat get() const override { return parts_ ? parts_->get() : matrix_.get(); }
  Mat rows() override;
  std::unique_ptr<PartsPreconditioner> preconditioner(const LinearMethod& method) const override;
  std::int64_t num_dofs() const { return num_nodes_of_all_ * block_size; }

  /// Vectors: right-hand side, solution, residual. @param b  of the nodes of K
  void set_right_hand_side(std::span<const double> b);
  Vec right_hand_side() const { return b_.get(); }
  Vec solution() const { return x_.get(); }
  /// |b - K x| of the vectors above.
  double residual_norm();
  /// Copy the solution. @param[out] x  of the nodes of K
  /// @note Collective.
  void take_solution(std::span<double> x) const;

 private:
  void create(const BlockMatrix<block_size>& K);
  void create_alone(const BlockMatrix<block_size>& K);
  void create_shared(const BlockMatrix<block_size>& K);
  void share_out_rows();
  void take_rows(const SharedNodes& shared);
  std::span<double> value_array(std::size_t size) const;
  std::vector<PetscInt> count_blocks(const BlockMatrix<block_size>& K) const;
  void insert_blocks(const BlockMatrix<block_size>& K, bool all_blocks);
  void add_rows(Packet& packet);
  void add_row(PetscInt row, std::span<const PetscInt> columns, std::span<const double> values);
  void copy_values(const BlockMatrix<block_size>& K);
  void assemble();

  MPI_Comm comm_;
  int rank_ = 0;
  int size_ = 1;
  SharedNodes shared_;
  std::int64_t pattern_id_ = 0, shared_id_ = 0;
  bool is_new_ = false;  // made since the last `set`
  std::int64_t num_nodes_of_all_ = 0;
  std::vector<PetscInt> numbers_;     // numbers of the nodes of K among those of all ranks
  std::vector<int> owners_;           // ranks that own them; one rank: empty
  std::vector<std::int32_t> owned_;   // ascending, with consecutive numbers
  std::vector<int> counts_, starts_;  // dofs of each rank, where every rank has all nodes
  MatHandle matrix_;                  // matrix of the parts: made when rows are asked for
  std::unique_ptr<MatrixParts<block_size>> parts_;
  const BlockMatrix<block_size>* K_ = nullptr;  // matrix of the parts
  bool rows_are_old_ = false;
  VecHandle b_, x_, r_;
};

}  // namespace gabion
