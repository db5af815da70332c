// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/petsc/matrix_parts.hpp"

#include <Eigen/LU>
#include <algorithm>

#include "common/mechanics/petsc/block_ilu.hpp"
#include "common/mechanics/petsc/petsc_session.hpp"
#include "common/mechanics/ranks/packet.hpp"

namespace gabion {

namespace {

template <int block_size>
constexpr std::size_t block_length = std::size_t{block_size} * block_size;

// Values of owned nodes among those of held ones.
template <int block_size>
void spread(const SharedNodes& shared, const double* own, std::vector<double>& held) {
  for (const std::int32_t i : shared.owned()) {
    std::copy_n(own, block_size, &held[static_cast<std::size_t>(i) * block_size]);
    own += block_size;
  }
}
template <int block_size>
void pick(const SharedNodes& shared, const std::vector<double>& held, double* own) {
  for (const std::int32_t i : shared.owned()) {
    own = std::copy_n(&held[static_cast<std::size_t>(i) * block_size], block_size, own);
  }
}

template <int block_size>
PetscErrorCode multiply_parts(Mat shell, Vec x, Vec y) {
  void* parts = nullptr;
  const double* from = nullptr;
  double* to = nullptr;
  PetscCall(MatShellGetContext(shell, static_cast<void*>(&parts)));
  PetscCall(VecGetArrayRead(x, &from));
  PetscCall(VecGetArrayWrite(y, &to));
  static_cast<MatrixParts<block_size>*>(parts)->multiply(from, to);
  PetscCall(VecRestoreArrayWrite(y, &to));
  PetscCall(VecRestoreArrayRead(x, &from));
  return 0;
}

template <int block_size>
class PartsJacobi final : public PartsPreconditioner {
 public:
  explicit PartsJacobi(std::vector<NodeBlock<block_size>> inverses)
      : inverses_(std::move(inverses)) {}
  void apply(std::span<const double> r, std::span<double> z) override {
    using NodeVector = Eigen::Matrix<double, block_size, 1>;
    for (std::size_t i = 0; i < inverses_.size(); ++i) {
      Eigen::Map<NodeVector>(&z[i * block_size]).noalias() =
          inverses_[i] * Eigen::Map<const NodeVector>(&r[i * block_size]);
    }
  }
  double bytes() const override {
    return static_cast<double>(inverses_.capacity() * sizeof(NodeBlock<block_size>));
  }

 private:
  std::vector<NodeBlock<block_size>> inverses_;  // inverse blocks of the owned nodes
};

template <int block_size>
class PartsIlu final : public PartsPreconditioner {
 public:
  PartsIlu(SharedNodes shared, bool overlapping, BlockIlu<block_size> factors, std::size_t num_held)
      : shared_(std::move(shared)),
        overlapping_(overlapping),
        factors_(std::move(factors)),
        x_(num_held * block_size, 0.0) {}
  void apply(std::span<const double> r, std::span<double> z) override {
    spread<block_size>(shared_, r.data(), x_);
    if (overlapping_) shared_.take_from_owners(x_, block_size);
    factors_.solve(x_);
    pick<block_size>(shared_, x_, z.data());
  }
  double bytes() const override { return factors_.bytes(); }

 private:
  SharedNodes shared_;
  bool overlapping_;
  BlockIlu<block_size> factors_;
  std::vector<double> x_;  // values at the held nodes; those of others stay 0 without overlap
};

// Pattern of this rank's part at the nodes that it shares with one other: row by row the number of
// blocks, their columns by the place in the list of these nodes, and the blocks.
template <int block_size>
Packet shared_blocks(const BlockMatrix<block_size>& K, std::span<const std::int32_t> nodes,
                     std::vector<std::int32_t>& place_of) {
  Packet packet;
  for (std::size_t k = 0; k < nodes.size(); ++k) place_of[nodes[k]] = static_cast<std::int32_t>(k);
  std::vector<std::int32_t> places;
  std::vector<double> blocks;
  for (const std::int32_t i : nodes) {
    places.clear();
    blocks.clear();
    for (std::int32_t s = K.row_starts()[i]; s < K.row_starts()[i + 1]; ++s) {
      const std::int32_t place = place_of[K.columns()[s]];
      if (place < 0) continue;
      places.push_back(place);
      const auto block = K.values().subspan(s * block_length<block_size>, block_length<block_size>);
      blocks.insert(blocks.end(), block.begin(), block.end());
    }
    packet.put(static_cast<std::int32_t>(places.size()));
    packet.put_all(std::span<const std::int32_t>(places));
    packet.put_all(std::span<const double>(blocks));
  }
  for (const std::int32_t i : nodes) place_of[i] = -1;
  return packet;
}

// Blocks that K has no place for are left out.
template <int block_size>
void add_blocks(const BlockMatrix<block_size>& K, std::span<const std::int32_t> nodes,
                Packet& packet, std::vector<double>& values) {
  std::vector<std::int32_t> places;
  std::vector<double> blocks;
  for (const std::int32_t i : nodes) {
    places.resize(packet.take<std::int32_t>());
    packet.take_all(places);
    blocks.resize(places.size() * block_length<block_size>);
    packet.take_all(blocks);
    const auto row =
        K.columns().subspan(K.row_starts()[i], K.row_starts()[i + 1] - K.row_starts()[i]);
    auto next = row.begin();
    for (std::size_t k = 0; k < places.size(); ++k) {
      const std::int32_t j = nodes[places[k]];
      next = std::lower_bound(next, row.end(), j);
      if (next == row.end() || *next != j) continue;
      const std::size_t slot = K.row_starts()[i] + (next - row.begin());
      for (std::size_t v = 0; v < block_length<block_size>; ++v) {
        values[slot * block_length<block_size> + v] += blocks[k * block_length<block_size> + v];
      }
    }
  }
}

// The blocks of the whole matrix in the places that K has.
template <int block_size>
std::vector<double> blocks_of_all(MPI_Comm comm, const BlockMatrix<block_size>& K,
                                  const SharedNodes& shared) {
  std::vector<std::int32_t> place_of(K.num_nodes(), -1);
  Packets out;
  for (int n = 0; n < shared.num_neighbours(); ++n) {
    out.emplace(shared.neighbour(n), shared_blocks(K, shared.shared_with(n), place_of));
  }
  Packets in = send_packets(comm, out);
  out.clear();
  std::vector<double> values(K.values().begin(), K.values().end());
  for (int n = 0; n < shared.num_neighbours(); ++n) {
    add_blocks(K, shared.shared_with(n), in.at(shared.neighbour(n)), values);
  }
  return values;
}

// Leave the blocks between owned nodes alone, and ones on the diagonal elsewhere.
template <int block_size>
void restrict_to_owned(const BlockMatrix<block_size>& K, const SharedNodes& shared,
                       std::vector<double>& values) {
  for (std::int32_t i = 0; i < K.num_nodes(); ++i) {
    for (std::int32_t s = K.row_starts()[i]; s < K.row_starts()[i + 1]; ++s) {
      const std::int32_t j = K.columns()[s];
      if (shared.owns(i) && shared.owns(j)) continue;
      Eigen::Map<NodeBlock<block_size>> block(&values[s * block_length<block_size>]);
      block.setZero();
      if (i == j) block.setIdentity();
    }
  }
}

}  // namespace

template <int block_size>
MatrixParts<block_size>::MatrixParts(MPI_Comm comm, const BlockMatrix<block_size>& K,
                                     SharedNodes shared)
    : K_(K), shared_(std::move(shared)) {
  x_.resize(static_cast<std::size_t>(K.num_nodes()) * block_size);
  y_.resize(x_.size());
  const auto local = static_cast<PetscInt>(shared_.owned().size()) * block_size;
  const auto global = static_cast<PetscInt>(shared_.num_of_all()) * block_size;
  check_petsc(MatCreateShell(comm, local, local, global, global, this, shell_.receive()),
              "MatCreateShell");
  check_petsc(MatShellSetOperation(shell_.get(), MATOP_MULT,
                                   reinterpret_cast<void (*)(void)>(&multiply_parts<block_size>)),
              "MatShellSetOperation");
}

template <int block_size>
void MatrixParts<block_size>::multiply(const double* x, double* y) {
  spread<block_size>(shared_, x, x_);
  shared_.take_from_owners(x_, block_size);
  K_.multiply(x_, y_);
  shared_.add_to_owners(y_, block_size);
  pick<block_size>(shared_, y_, y);
}

template <int block_size>
std::unique_ptr<PartsPreconditioner> MatrixParts<block_size>::preconditioner(
    const LinearMethod& method) const {
  if (method.preconditioner == Preconditioner::jacobi) return make_jacobi();
  if (method.preconditioner == Preconditioner::ilu) {
    return make_ilu(method.method != SolutionMethod::cg);
  }
  return nullptr;
}

template <int block_size>
std::unique_ptr<PartsPreconditioner> MatrixParts<block_size>::make_jacobi() const {
  constexpr std::size_t length = block_length<block_size>;
  std::vector<double> diagonal;
  diagonal.reserve(static_cast<std::size_t>(K_.num_nodes()) * length);
  for (const std::int32_t s : K_.diagonal()) {
    const auto block = K_.values().subspan(s * length, length);
    diagonal.insert(diagonal.end(), block.begin(), block.end());
  }
  shared_.add_to_owners(diagonal, length);
  std::vector<NodeBlock<block_size>> inverses;
  inverses.reserve(shared_.owned().size());
  for (const std::int32_t i : shared_.owned()) {
    inverses.push_back(Eigen::Map<NodeBlock<block_size>>(&diagonal[i * length]).inverse());
  }
  return std::make_unique<PartsJacobi<block_size>>(std::move(inverses));
}

template <int block_size>
std::unique_ptr<PartsPreconditioner> MatrixParts<block_size>::make_ilu(bool overlapping) const {
  MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(shell_.get()));
  std::vector<double> values = blocks_of_all(comm, K_, shared_);
  if (!overlapping) restrict_to_owned(K_, shared_, values);
  return std::make_unique<PartsIlu<block_size>>(
      shared_, overlapping, BlockIlu<block_size>(K_, std::move(values)), K_.num_nodes());
}

template class MatrixParts<2>;
template class MatrixParts<3>;
template class MatrixParts<4>;

}  // namespace gabion
