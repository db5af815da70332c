// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/petsc/shared_nodes.hpp"

#include <petscsf.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "common/mechanics/norm.hpp"
#include "common/mechanics/petsc/petsc_handle.hpp"
#include "common/mechanics/petsc/petsc_session.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "common/mechanics/ranks/text.hpp"

namespace gabion {

namespace {

using SfHandle = PetscHandle<PetscSF, PetscSFDestroy>;
using LayoutHandle = PetscHandle<PetscLayout, PetscLayoutDestroy>;

// The root of each leaf stands in a layout under the leaf's number.
void make_forest(MPI_Comm comm, PetscLayout layout, std::span<const std::int32_t> numbers,
                 SfHandle& forest) {
  check_petsc(PetscSFCreate(comm, forest.receive()), "PetscSFCreate");
  check_petsc(PetscSFSetGraphLayout(forest.get(), layout, static_cast<PetscInt>(numbers.size()),
                                    nullptr, PETSC_OWN_POINTER, numbers.data()),
              "PetscSFSetGraphLayout");
  check_petsc(PetscSFSetUp(forest.get()), "PetscSFSetUp");
}

void reduce(PetscSF forest, MPI_Datatype type, const void* leaves, void* roots, MPI_Op op) {
  check_petsc(PetscSFReduceBegin(forest, type, leaves, roots, op), "PetscSFReduceBegin");
  check_petsc(PetscSFReduceEnd(forest, type, leaves, roots, op), "PetscSFReduceEnd");
}

void broadcast(PetscSF forest, MPI_Datatype type, const void* roots, void* leaves) {
  check_petsc(PetscSFBcastBegin(forest, type, roots, leaves, MPI_REPLACE), "PetscSFBcastBegin");
  check_petsc(PetscSFBcastEnd(forest, type, roots, leaves, MPI_REPLACE), "PetscSFBcastEnd");
}

// Where nodes meet that several ranks hold: the ids are shared out among the ranks, whoever holds
// them.
class Directory {
 public:
  Directory(MPI_Comm comm, std::span<const std::int32_t> ids, std::int32_t num_ids) {
    check_petsc(PetscLayoutCreateFromSizes(comm, PETSC_DECIDE, num_ids, 1, layout_.receive()),
                "PetscLayoutCreateFromSizes");
    PetscInt num_roots = 0;
    check_petsc(PetscLayoutGetLocalSize(layout_.get(), &num_roots), "PetscLayoutGetLocalSize");
    roots_.resize(num_roots);
    make_forest(comm, layout_.get(), ids, forest_);
  }
  // The best value that a holder of each node has.
  std::vector<PetscInt> best(std::vector<PetscInt> own, PetscInt worst, MPI_Op op) {
    std::fill(roots_.begin(), roots_.end(), worst);
    reduce(forest_.get(), MPIU_INT, own.data(), roots_.data(), op);
    broadcast(forest_.get(), MPIU_INT, roots_.data(), own.data());
    return own;
  }

 private:
  LayoutHandle layout_;
  SfHandle forest_;
  std::vector<PetscInt> roots_;
};

}  // namespace

struct SharedNodes::Graph {
  Graph(MPI_Comm comm_, std::span<const std::int32_t> ids, std::int32_t num_ids) : comm(comm_) {
    static std::int64_t last_id = 0;  // all ranks count alike
    id = ++last_id;
    Directory directory(comm, ids, num_ids);
    const std::size_t n = ids.size();
    rank = rank_of(comm);
    owners = directory.best(std::vector<PetscInt>(n, rank), num_ranks(comm), MPI_MIN);
    for (std::size_t i = 0; i < n; ++i) {
      if (owners[i] == rank) owned.push_back(static_cast<std::int32_t>(i));
    }
    const std::int64_t own = static_cast<std::int64_t>(owned.size());
    std::int64_t end = 0;
    MPI_Scan(&own, &end, 1, MPI_INT64_T, MPI_SUM, comm);
    MPI_Allreduce(&own, &num_of_all, 1, MPI_INT64_T, MPI_SUM, comm);
    numbers.assign(n, -1);
    auto next = static_cast<PetscInt>(end - own);
    for (const std::int32_t i : owned) numbers[i] = next++;
    numbers = directory.best(std::move(numbers), -1, MPI_MAX);
  }
  Graph(const Graph&) = delete;
  Graph& operator=(const Graph&) = delete;
  Graph(Graph&&) = delete;
  Graph& operator=(Graph&&) = delete;

  PetscSF forest(int components) const;

  MPI_Comm comm;
  std::int64_t id = 0;
  int rank = 0;
  std::vector<PetscInt> owners;     // ranks
  std::vector<std::int32_t> owned;  // ascending
  std::vector<PetscInt> numbers;
  std::int64_t num_of_all = 0;
  // Roots are the values of the owned nodes, leaves those of the held ones; of each number of
  // components, made when it is asked for. PETSc sums numbers only, no vectors of them.
  mutable std::map<int, SfHandle> forests;
};

PetscSF SharedNodes::Graph::forest(int components) const {
  SfHandle& forest = forests[components];
  if (forest) return forest.get();
  LayoutHandle layout;
  const auto num_roots = static_cast<PetscInt>(owned.size()) * components;
  check_petsc(PetscLayoutCreateFromSizes(comm, num_roots, PETSC_DECIDE, 1, layout.receive()),
              "PetscLayoutCreateFromSizes");
  std::vector<PetscInt> leaves;
  leaves.reserve(numbers.size() * components);
  for (const PetscInt number : numbers) {
    for (int c = 0; c < components; ++c) leaves.push_back(number * components + c);
  }
  make_forest(comm, layout.get(), leaves, forest);
  return forest.get();
}

SharedNodes::SharedNodes(MPI_Comm comm, std::span<const std::int32_t> ids, std::int32_t num_ids) {
  if (num_ranks(comm) > 1) graph_ = std::make_shared<const Graph>(comm, ids, num_ids);
}

std::int64_t SharedNodes::id() const {
  return alone() ? 0 : graph_->id;
}

bool SharedNodes::owns_shared(std::int32_t node) const {
  return graph_->owners[node] == graph_->rank;
}

int SharedNodes::owner(std::int32_t node) const {
  return graph_->owners[node];
}

std::span<const std::int32_t> SharedNodes::numbers() const {
  return graph_->numbers;
}

std::int32_t SharedNodes::num_owned() const {
  return static_cast<std::int32_t>(graph_->owned.size());
}

std::int64_t SharedNodes::num_of_all() const {
  return graph_->num_of_all;
}

void SharedNodes::sum(std::span<double> values, int components) const {
  if (alone()) return;
  std::vector<double> roots(graph_->owned.size() * components, 0.0);
  PetscSF forest = graph_->forest(components);
  reduce(forest, MPIU_REAL, values.data(), roots.data(), MPI_SUM);
  broadcast(forest, MPIU_REAL, roots.data(), values.data());
}

void SharedNodes::sum(std::span<double> a, std::span<double> b, int components) const {
  if (alone()) return;
  const auto width = static_cast<std::size_t>(components);
  std::vector<double> both;
  both.reserve(2 * a.size());
  for (std::size_t k = 0; k < a.size(); k += width) {
    both.insert(both.end(), &a[k], &a[k] + width);
    both.insert(both.end(), &b[k], &b[k] + width);
  }
  sum(both, 2 * components);
  const double* next = both.data();
  for (std::size_t k = 0; k < a.size(); k += width) {
    std::copy_n(next, width, &a[k]);
    std::copy_n(next + width, width, &b[k]);
    next += 2 * width;
  }
}

void SharedNodes::take_from_owners(std::span<double> values, int components) const {
  if (alone()) return;
  std::vector<double> roots;
  roots.reserve(graph_->owned.size() * components);
  for (const std::int32_t i : graph_->owned) {
    const auto of_node = values.subspan(static_cast<std::size_t>(i) * components,
                                        static_cast<std::size_t>(components));
    roots.insert(roots.end(), of_node.begin(), of_node.end());
  }
  broadcast(graph_->forest(components), MPIU_REAL, roots.data(), values.data());
}

double SharedNodes::total(double own) const {
  total(std::span<double>(&own, 1));
  return own;
}

void SharedNodes::total(std::span<double> own) const {
  if (!alone()) sum_over_ranks(graph_->comm, own);
}

double SharedNodes::largest(double own) const {
  return alone() ? own : max_over_ranks(graph_->comm, own);
}

bool SharedNodes::all(bool own) const {
  return alone() ? own : max_over_ranks(graph_->comm, own ? 0 : 1) == 0;
}

std::string SharedNodes::first_text(std::string own) const {
  return alone() ? own : gabion::first_text(graph_->comm, std::move(own));
}

double SharedNodes::dot(std::span<const double> a, std::span<const double> b) const {
  return total(own_dot(a, b));
}

double SharedNodes::own_dot(std::span<const double> a, std::span<const double> b) const {
  double sum = 0;
  if (alone()) {
    for (std::size_t k = 0; k < a.size(); ++k) sum += a[k] * b[k];
    return sum;
  }
  const std::size_t components = a.empty() ? 0 : a.size() / graph_->owners.size();
  for (const std::int32_t i : graph_->owned) {
    for (std::size_t k = i * components; k < (i + 1) * components; ++k) sum += a[k] * b[k];
  }
  return sum;
}

double SharedNodes::norm(std::span<const double> a) const {
  return alone() ? norm_of(a) : std::sqrt(dot(a, a));
}

}  // namespace gabion
