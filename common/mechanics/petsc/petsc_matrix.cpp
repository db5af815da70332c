// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/petsc/petsc_matrix.hpp"

#include <algorithm>

#include "common/mechanics/petsc/petsc_session.hpp"

static_assert(sizeof(PetscInt) == sizeof(std::int32_t));

namespace gabion {

template <int block_size>
PetscMatrix<block_size>::PetscMatrix(MPI_Comm comm) : comm_(comm) {
  MPI_Comm_rank(comm, &rank_);
  MPI_Comm_size(comm, &size_);
}

template <int block_size>
bool PetscMatrix<block_size>::set(const BlockMatrix<block_size>& K) {
  int renew = !matrix_ || K.pattern_id() != pattern_id_;
  if (size_ > 1) MPI_Allreduce(MPI_IN_PLACE, &renew, 1, MPI_INT, MPI_MAX, comm_);
  pattern_id_ = K.pattern_id();
  if (renew) create(K);
  if (size_ == 1) {
    copy_values(K);
  } else {
    if (!renew) check_petsc(MatZeroEntries(matrix_.get()), "MatZeroEntries");
    insert_blocks(K, renew);
  }
  assemble();
  return renew;
}

template <int block_size>
void PetscMatrix<block_size>::share_out_rows() {
  counts_.resize(size_);
  starts_.resize(size_);
  const auto first_node = [this](int r) {
    return static_cast<int>(static_cast<std::int64_t>(num_nodes_) * r / size_);
  };
  for (int r = 0; r < size_; ++r) {
    starts_[r] = first_node(r) * block_size;
    counts_[r] = (first_node(r + 1) - first_node(r)) * block_size;
  }
}

template <int block_size>
void PetscMatrix<block_size>::create(const BlockMatrix<block_size>& K) {
  num_nodes_ = K.num_nodes();
  share_out_rows();
  size_ == 1 ? create_alone(K) : create_shared(K);
  check_petsc(MatCreateVecs(matrix_.get(), x_.receive(), b_.receive()), "MatCreateVecs");
  check_petsc(VecDuplicate(b_.get(), r_.receive()), "VecDuplicate");
}

// The blocks of PETSc's sequential matrix are in the same order as those of K: nothing is inserted.
template <int block_size>
void PetscMatrix<block_size>::create_alone(const BlockMatrix<block_size>& K) {
  std::vector<PetscInt> counts(num_nodes_);
  for (std::int32_t i = 0; i < num_nodes_; ++i) {
    counts[i] = K.row_starts()[i + 1] - K.row_starts()[i];
  }
  const PetscInt size = num_nodes_ * block_size;
  check_petsc(MatCreateSeqBAIJ(comm_, block_size, size, size, 0, counts.data(), matrix_.receive()),
              "MatCreateSeqBAIJ");
  std::vector<PetscInt> columns(K.columns().begin(), K.columns().end());  // PETSc copies them
  check_petsc(MatSeqBAIJSetColumnIndices(matrix_.get(), columns.data()),
              "MatSeqBAIJSetColumnIndices");
}

template <int block_size>
void PetscMatrix<block_size>::create_shared(const BlockMatrix<block_size>& K) {
  std::vector<PetscInt> inside(num_nodes_, 0), outside(num_nodes_, 0);  // blocks in each row
  for (int r = 0; r < size_; ++r) {
    const std::int32_t first = starts_[r] / block_size, last = first + counts_[r] / block_size;
    for (std::int32_t i = first; i < last; ++i)
      for (std::int32_t s = K.row_starts()[i]; s < K.row_starts()[i + 1]; ++s) {
        const std::int32_t j = K.columns()[s];
        ++(j >= first && j < last ? inside[i] : outside[i]);
      }
  }
  const std::int32_t own = starts_[rank_] / block_size, own_count = counts_[rank_] / block_size;
  // An upper bound: blocks that several ranks hold are counted several times.
  MPI_Allreduce(MPI_IN_PLACE, inside.data(), num_nodes_, MPI_INT32_T, MPI_SUM, comm_);
  MPI_Allreduce(MPI_IN_PLACE, outside.data(), num_nodes_, MPI_INT32_T, MPI_SUM, comm_);
  for (std::int32_t i = own; i < own + own_count; ++i) {
    inside[i] = std::min<PetscInt>(inside[i], own_count);
    outside[i] = std::min<PetscInt>(outside[i], num_nodes_ - own_count);
  }
  const PetscInt local = counts_[rank_], global = num_nodes_ * block_size;
  check_petsc(MatCreateBAIJ(comm_, block_size, local, local, global, global, 0, inside.data() + own,
                            0, outside.data() + own, matrix_.receive()),
              "MatCreateBAIJ");
  check_petsc(MatSetOption(matrix_.get(), MAT_ROW_ORIENTED, PETSC_FALSE), "MatSetOption");
}

template <int block_size>
void PetscMatrix<block_size>::insert_blocks(const BlockMatrix<block_size>& K, bool all_blocks) {
  const std::int32_t own = starts_[rank_] / block_size, own_end = own + counts_[rank_] / block_size;
  for (std::int32_t i = 0; i < num_nodes_; ++i) {
    const bool is_own = i >= own && i < own_end;
    // Rows of other ranks travel only when they hold something, except to make a new pattern.
    const auto row =
        K.values().subspan(static_cast<std::size_t>(K.row_starts()[i]) * block_size * block_size,
                           static_cast<std::size_t>(K.row_starts()[i + 1] - K.row_starts()[i]) *
                               block_size * block_size);
    if (!is_own && !all_blocks &&
        std::all_of(row.begin(), row.end(), [](double v) { return v == 0; }))
      continue;
    insert_row(K, i, is_own);
  }
}

template <int block_size>
void PetscMatrix<block_size>::insert_row(const BlockMatrix<block_size>& K, std::int32_t i,
                                         bool is_own) {
  const std::int32_t begin = K.row_starts()[i], end = K.row_starts()[i + 1];
  // PETSc 3.18 mixes up the columns of several column-major blocks that go to another rank.
  const std::int32_t at_once = is_own ? end - begin : 1;
  for (std::int32_t s = begin; s < end; s += at_once)
    check_petsc(
        MatSetValuesBlocked(
            matrix_.get(), 1, &i, at_once, K.columns().data() + s,
            K.values().data() + static_cast<std::size_t>(s) * block_size * block_size, ADD_VALUES),
        "MatSetValuesBlocked");
}

template <int block_size>
void PetscMatrix<block_size>::copy_values(const BlockMatrix<block_size>& K) {
  double* values = nullptr;
  check_petsc(MatSeqBAIJGetArray(matrix_.get(), &values), "MatSeqBAIJGetArray");
  std::copy(K.values().begin(), K.values().end(), values);
  check_petsc(MatSeqBAIJRestoreArray(matrix_.get(), &values), "MatSeqBAIJRestoreArray");
}

template <int block_size>
void PetscMatrix<block_size>::assemble() {
  check_petsc(MatAssemblyBegin(matrix_.get(), MAT_FINAL_ASSEMBLY), "MatAssemblyBegin");
  check_petsc(MatAssemblyEnd(matrix_.get(), MAT_FINAL_ASSEMBLY), "MatAssemblyEnd");
}

template <int block_size>
void PetscMatrix<block_size>::set_right_hand_side(std::span<const double> b) {
  double* values = nullptr;
  check_petsc(VecGetArrayWrite(b_.get(), &values), "VecGetArrayWrite");
  std::copy_n(b.data() + starts_[rank_], counts_[rank_], values);
  check_petsc(VecRestoreArrayWrite(b_.get(), &values), "VecRestoreArrayWrite");
}

template <int block_size>
double PetscMatrix<block_size>::residual_norm() {
  PetscReal norm = 0;
  check_petsc(MatMult(matrix_.get(), x_.get(), r_.get()), "MatMult");
  check_petsc(VecAYPX(r_.get(), -1, b_.get()), "VecAYPX");
  check_petsc(VecNorm(r_.get(), NORM_2, &norm), "VecNorm");
  return norm;
}

template <int block_size>
void PetscMatrix<block_size>::replicate_solution(std::span<double> x) const {
  const double* values = nullptr;
  check_petsc(VecGetArrayRead(x_.get(), &values), "VecGetArrayRead");
  if (size_ == 1) {
    std::copy_n(values, counts_[0], x.data());
  } else {
    MPI_Allgatherv(values, counts_[rank_], MPI_DOUBLE, x.data(), counts_.data(), starts_.data(),
                   MPI_DOUBLE, comm_);
  }
  check_petsc(VecRestoreArrayRead(x_.get(), &values), "VecRestoreArrayRead");
}

template class PetscMatrix<1>;
template class PetscMatrix<2>;
template class PetscMatrix<3>;
template class PetscMatrix<6>;

}  // namespace gabion
