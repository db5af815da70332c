// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/petsc/petsc_matrix.hpp"

#include <algorithm>
#include <utility>

#include "common/base/require.hpp"
#include "common/mechanics/petsc/block_multiply.hpp"
#include "common/mechanics/petsc/petsc_session.hpp"
#include "common/mechanics/ranks/sum.hpp"

static_assert(sizeof(PetscInt) == sizeof(std::int32_t));

namespace gabion {

namespace {

// MatMult of a sequential BAIJ matrix with the vector units that PETSc's own build may not use.
template <int block_size>
PetscErrorCode multiply_alone(Mat matrix, Vec x, Vec y) {
  PetscInt n = 0;
  const PetscInt *row_starts = nullptr, *columns = nullptr;
  PetscBool done = PETSC_FALSE;
  double* values = nullptr;
  const double* from = nullptr;
  double* to = nullptr;
  PetscCall(MatGetRowIJ(matrix, 0, PETSC_FALSE, PETSC_TRUE, &n, &row_starts, &columns, &done));
  PetscCheck(done, PETSC_COMM_SELF, PETSC_ERR_SUP, "no rows");
  PetscCall(MatSeqBAIJGetArray(matrix, &values));
  PetscCall(VecGetArrayRead(x, &from));
  PetscCall(VecGetArrayWrite(y, &to));
  multiply_blocks<block_size>({row_starts, columns, values}, n, from, to);
  PetscCall(VecRestoreArrayWrite(y, &to));
  PetscCall(VecRestoreArrayRead(x, &from));
  PetscCall(MatSeqBAIJRestoreArray(matrix, &values));
  return MatRestoreRowIJ(matrix, 0, PETSC_FALSE, PETSC_TRUE, &n, &row_starts, &columns, &done);
}

}  // namespace

template <int block_size>
PetscMatrix<block_size>::PetscMatrix(MPI_Comm comm) : comm_(comm) {
  MPI_Comm_rank(comm, &rank_);
  MPI_Comm_size(comm, &size_);
}

template <int block_size>
std::span<double> PetscMatrix<block_size>::make_room(const BlockMatrix<block_size>& K) {
  require(size_ == 1, "PetscMatrix::make_room: found {} ranks, allowed: 1", size_);
  pattern_id_ = K.pattern_id();
  shared_ = {};
  shared_id_ = shared_.id();
  create(K);
  is_new_ = true;
  return value_array(K.columns().size() * block_size * block_size);
}

template <int block_size>
bool PetscMatrix<block_size>::set(const BlockMatrix<block_size>& K, const SharedNodes& shared) {
  int renew =
      !get() || (parts_ && &K != K_) || K.pattern_id() != pattern_id_ || shared.id() != shared_id_;
  if (size_ > 1) MPI_Allreduce(MPI_IN_PLACE, &renew, 1, MPI_INT, MPI_MAX, comm_);
  pattern_id_ = K.pattern_id();
  shared_id_ = shared.id();
  shared_ = shared;
  if (renew) create(K);
  K_ = &K;
  rows_are_old_ = true;
  if (parts_) return renew;
  if (size_ == 1) {
    copy_values(K);
  } else {
    if (!renew) check_petsc(MatZeroEntries(matrix_.get()), "MatZeroEntries");
    insert_blocks(K, renew);
  }
  assemble();
  return std::exchange(is_new_, false) || renew;
}

template <int block_size>
Mat PetscMatrix<block_size>::rows() {
  if (!parts_ || !rows_are_old_) return matrix_.get();
  const bool is_new = !matrix_;
  if (is_new) {
    create_shared(*K_);
  } else {
    check_petsc(MatZeroEntries(matrix_.get()), "MatZeroEntries");
  }
  insert_blocks(*K_, is_new);
  assemble();
  rows_are_old_ = false;
  return matrix_.get();
}

template <int block_size>
std::unique_ptr<PartsPreconditioner> PetscMatrix<block_size>::preconditioner(
    const LinearMethod& method) const {
  return parts_ ? parts_->preconditioner(method) : nullptr;
}

// Every rank has all nodes: equal parts.
template <int block_size>
void PetscMatrix<block_size>::share_out_rows() {
  counts_.resize(size_);
  starts_.resize(size_);
  const auto num_nodes = static_cast<std::int64_t>(numbers_.size());
  const auto first_node = [&](int r) { return static_cast<int>(num_nodes * r / size_); };
  for (int r = 0; r < size_; ++r) {
    starts_[r] = first_node(r) * block_size;
    counts_[r] = (first_node(r + 1) - first_node(r)) * block_size;
    for (int i = first_node(r); i < first_node(r + 1); ++i) {
      numbers_[i] = i;
      owners_.push_back(r);
    }
  }
  num_nodes_of_all_ = num_nodes;
}

template <int block_size>
void PetscMatrix<block_size>::take_rows(const SharedNodes& shared) {
  numbers_.assign(shared.numbers().begin(), shared.numbers().end());
  for (std::size_t i = 0; i < numbers_.size(); ++i) {
    owners_.push_back(shared.owner(static_cast<std::int32_t>(i)));
  }
  num_nodes_of_all_ = shared.num_of_all();
}

template <int block_size>
void PetscMatrix<block_size>::create(const BlockMatrix<block_size>& K) {
  numbers_.assign(K.num_nodes(), 0);
  owners_.clear();
  owned_.clear();
  if (shared_.alone()) {
    share_out_rows();
  } else {
    take_rows(shared_);
  }
  for (std::int32_t i = 0; i < K.num_nodes(); ++i) {
    if (owners_[i] == rank_) owned_.push_back(i);
  }
  matrix_.reset();
  parts_.reset();
  if (size_ == 1) {
    create_alone(K);
  } else if (shared_.alone()) {
    create_shared(K);
  } else {
    parts_ = std::make_unique<MatrixParts<block_size>>(comm_, K, shared_);
  }
  check_petsc(MatCreateVecs(get(), x_.receive(), b_.receive()), "MatCreateVecs");
  check_petsc(VecDuplicate(b_.get(), r_.receive()), "VecDuplicate");
}

// The blocks of PETSc's sequential matrix are in the same order as those of K: nothing is inserted.
template <int block_size>
void PetscMatrix<block_size>::create_alone(const BlockMatrix<block_size>& K) {
  std::vector<PetscInt> counts(K.num_nodes());
  for (std::int32_t i = 0; i < K.num_nodes(); ++i) {
    counts[i] = K.row_starts()[i + 1] - K.row_starts()[i];
  }
  const PetscInt size = K.num_nodes() * block_size;
  check_petsc(MatCreateSeqBAIJ(comm_, block_size, size, size, 0, counts.data(), matrix_.receive()),
              "MatCreateSeqBAIJ");
  std::vector<PetscInt> columns(K.columns().begin(), K.columns().end());  // PETSc copies them
  check_petsc(MatSeqBAIJSetColumnIndices(matrix_.get(), columns.data()),
              "MatSeqBAIJSetColumnIndices");
  check_petsc(MatSetOperation(matrix_.get(), MATOP_MULT,
                              reinterpret_cast<void (*)(void)>(&multiply_alone<block_size>)),
              "MatSetOperation");
}

// Blocks in each row whose column belongs to the rank of the row, and in other columns. An upper
// bound: blocks that several ranks hold are counted several times.
template <int block_size>
std::vector<PetscInt> PetscMatrix<block_size>::count_blocks(
    const BlockMatrix<block_size>& K) const {
  std::vector<double> counts(2 * numbers_.size(), 0.0);
  for (std::int32_t i = 0; i < K.num_nodes(); ++i) {
    for (std::int32_t s = K.row_starts()[i]; s < K.row_starts()[i + 1]; ++s) {
      const bool inside = owners_[K.columns()[s]] == owners_[i];
      ++counts[2 * static_cast<std::size_t>(i) + (inside ? 0 : 1)];
    }
  }
  if (shared_.alone()) {
    sum_over_ranks(comm_, std::span<double>(counts));
  } else {
    shared_.sum(counts, 2);
  }
  return {counts.begin(), counts.end()};
}

template <int block_size>
void PetscMatrix<block_size>::create_shared(const BlockMatrix<block_size>& K) {
  const std::vector<PetscInt> counts = count_blocks(K);
  const auto num_owned = static_cast<PetscInt>(owned_.size());
  const auto num_others = static_cast<PetscInt>(num_nodes_of_all_) - num_owned;
  std::vector<PetscInt> inside, outside;
  for (const std::int32_t i : owned_) {
    inside.push_back(std::min(counts[2 * static_cast<std::size_t>(i)], num_owned));
    outside.push_back(std::min(counts[2 * static_cast<std::size_t>(i) + 1], num_others));
  }
  const PetscInt local = num_owned * block_size;
  const PetscInt global = static_cast<PetscInt>(num_nodes_of_all_) * block_size;
  check_petsc(MatCreateBAIJ(comm_, block_size, local, local, global, global, 0, inside.data(), 0,
                            outside.data(), matrix_.receive()),
              "MatCreateBAIJ");
  for (const auto& [option, value] :
       {std::pair(MAT_ROW_ORIENTED, PETSC_FALSE), std::pair(MAT_NO_OFF_PROC_ENTRIES, PETSC_TRUE)}) {
    check_petsc(MatSetOption(matrix_.get(), option, value), "MatSetOption");
  }
}

// Rows of other ranks go to these in packets, not through PETSc: it adds them as they arrive.
template <int block_size>
void PetscMatrix<block_size>::insert_blocks(const BlockMatrix<block_size>& K, bool all_blocks) {
  constexpr std::size_t width = block_size * block_size;
  Packets out;
  std::vector<PetscInt> columns;
  for (std::int32_t i = 0; i < K.num_nodes(); ++i) {
    const std::int32_t begin = K.row_starts()[i], end = K.row_starts()[i + 1];
    const auto values = K.values().subspan(begin * width, (end - begin) * width);
    columns.clear();
    for (std::int32_t s = begin; s < end; ++s) columns.push_back(numbers_[K.columns()[s]]);
    if (owners_[i] == rank_) {
      add_row(numbers_[i], columns, values);
    } else if (all_blocks ||
               std::any_of(values.begin(), values.end(), [](double v) { return v != 0; })) {
      Packet& packet = out[owners_[i]];
      packet.put(numbers_[i]);
      packet.put(end - begin);
      packet.put_all(std::span<const PetscInt>(columns));
      packet.put_all(values);
    }
  }
  for (auto& [rank, packet] : send_packets(comm_, out)) add_rows(packet);
}

template <int block_size>
void PetscMatrix<block_size>::add_rows(Packet& packet) {
  std::vector<PetscInt> columns;
  std::vector<double> values;
  while (!packet.empty()) {
    const auto row = packet.take<PetscInt>();
    columns.resize(packet.take<std::int32_t>());
    packet.take_all(columns);
    values.resize(columns.size() * block_size * block_size);
    packet.take_all(values);
    add_row(row, columns, values);
  }
}

template <int block_size>
void PetscMatrix<block_size>::add_row(PetscInt row, std::span<const PetscInt> columns,
                                      std::span<const double> values) {
  check_petsc(MatSetValuesBlocked(matrix_.get(), 1, &row, static_cast<PetscInt>(columns.size()),
                                  columns.data(), values.data(), ADD_VALUES),
              "MatSetValuesBlocked");
}

template <int block_size>
std::span<double> PetscMatrix<block_size>::value_array(std::size_t size) const {
  double* values = nullptr;
  check_petsc(MatSeqBAIJGetArray(matrix_.get(), &values), "MatSeqBAIJGetArray");
  double* const first = values;
  check_petsc(MatSeqBAIJRestoreArray(matrix_.get(), &values), "MatSeqBAIJRestoreArray");
  return {first, size};
}

template <int block_size>
void PetscMatrix<block_size>::copy_values(const BlockMatrix<block_size>& K) {
  const std::span<double> values = value_array(K.values().size());
  if (values.data() == K.values().data()) return;
  std::copy(K.values().begin(), K.values().end(), values.begin());
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
  double* next = values;
  for (const std::int32_t i : owned_) {
    next = std::copy_n(b.data() + static_cast<std::size_t>(i) * block_size, block_size, next);
  }
  check_petsc(VecRestoreArrayWrite(b_.get(), &values), "VecRestoreArrayWrite");
}

template <int block_size>
double PetscMatrix<block_size>::residual_norm() {
  PetscReal norm = 0;
  check_petsc(MatMult(get(), x_.get(), r_.get()), "MatMult");
  check_petsc(VecAYPX(r_.get(), -1, b_.get()), "VecAYPX");
  check_petsc(VecNorm(r_.get(), NORM_2, &norm), "VecNorm");
  return norm;
}

template <int block_size>
void PetscMatrix<block_size>::take_solution(std::span<double> x) const {
  const double* values = nullptr;
  check_petsc(VecGetArrayRead(x_.get(), &values), "VecGetArrayRead");
  if (size_ > 1 && shared_.alone()) {
    MPI_Allgatherv(values, counts_[rank_], MPI_DOUBLE, x.data(), counts_.data(), starts_.data(),
                   MPI_DOUBLE, comm_);
  } else {
    const double* next = values;
    for (const std::int32_t i : owned_) {
      std::copy_n(next, block_size, x.data() + static_cast<std::size_t>(i) * block_size);
      next += block_size;
    }
    shared_.take_from_owners(x, block_size);
  }
  check_petsc(VecRestoreArrayRead(x_.get(), &values), "VecRestoreArrayRead");
}

template class PetscMatrix<2>;
template class PetscMatrix<3>;
template class PetscMatrix<4>;

}  // namespace gabion
