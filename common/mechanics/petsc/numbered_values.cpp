// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/petsc/numbered_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "common/base/require.hpp"
#include "common/mechanics/petsc/petsc_session.hpp"
#include "common/mechanics/ranks/text.hpp"

namespace gabion {

namespace {

/// A row of values as one unit of a message.
class RowType {
 public:
  explicit RowType(int width) {
    MPI_Type_contiguous(width, MPI_DOUBLE, &type_);
    MPI_Type_commit(&type_);
  }
  ~RowType() { MPI_Type_free(&type_); }
  RowType(const RowType&) = delete;
  RowType& operator=(const RowType&) = delete;
  RowType(RowType&&) = delete;
  RowType& operator=(RowType&&) = delete;
  MPI_Datatype get() const { return type_; }

 private:
  MPI_Datatype type_ = MPI_DATATYPE_NULL;
};

void reduce(PetscSF forest, MPI_Datatype unit, const void* leaves, void* roots, MPI_Op op) {
  check_petsc(PetscSFReduceBegin(forest, unit, leaves, roots, op), "PetscSFReduceBegin");
  check_petsc(PetscSFReduceEnd(forest, unit, leaves, roots, op), "PetscSFReduceEnd");
}

}  // namespace

NumberedValues::NumberedValues(MPI_Comm comm, std::span<const std::int64_t> given,
                               std::span<const std::int32_t> wanted, std::int32_t end,
                               std::string what)
    : comm_(comm), what_(std::move(what)), num_wanted_(wanted.size()) {
  together(comm, [&] {
    for (const std::int64_t number : given) {
      require(number >= 0 && number < end, "{}: found {}, allowed: 0 to {}", what_, number,
              end - 1);
    }
  });
  PetscHandle<PetscLayout, PetscLayoutDestroy> layout;
  check_petsc(PetscLayoutCreateFromSizes(comm, PETSC_DECIDE, end, 1, layout.receive()),
              "PetscLayoutCreateFromSizes");
  PetscInt num_roots = 0;
  check_petsc(PetscLayoutGetLocalSize(layout.get(), &num_roots), "PetscLayoutGetLocalSize");
  num_roots_ = static_cast<std::size_t>(num_roots);
  const auto grow = [&](Forest& forest, const std::vector<PetscInt>& numbers) {
    check_petsc(PetscSFCreate(comm, forest.receive()), "PetscSFCreate");
    check_petsc(
        PetscSFSetGraphLayout(forest.get(), layout.get(), static_cast<PetscInt>(numbers.size()),
                              nullptr, PETSC_OWN_POINTER, numbers.data()),
        "PetscSFSetGraphLayout");
  };
  grow(from_, {given.begin(), given.end()});
  grow(to_, {wanted.begin(), wanted.end()});
  require_each_once(given);
}

void NumberedValues::require_each_once(std::span<const std::int64_t> given) const {
  const std::vector<PetscInt> ones(given.size(), 1);
  std::vector<PetscInt> counts(num_roots_, 0);
  reduce(from_.get(), MPIU_INT, ones.data(), counts.data(), MPI_SUM);
  const auto wrong = std::ranges::find_if(counts, [](PetscInt count) { return count != 1; });
  std::string problem;
  if (wrong != counts.end()) {
    problem = fmt::format("{}: found a number {} times, allowed: each once", what_, *wrong);
  }
  const std::string told = first_text(comm_, problem);
  require(told.empty(), told);
}

std::vector<double> NumberedValues::send(std::span<const double> given, int width) const {
  const RowType row(width);
  std::vector<double> roots(num_roots_ * width), wanted(num_wanted_ * width);
  reduce(from_.get(), row.get(), given.data(), roots.data(), MPI_REPLACE);
  check_petsc(PetscSFBcastBegin(to_.get(), row.get(), roots.data(), wanted.data(), MPI_REPLACE),
              "PetscSFBcastBegin");
  check_petsc(PetscSFBcastEnd(to_.get(), row.get(), roots.data(), wanted.data(), MPI_REPLACE),
              "PetscSFBcastEnd");
  return wanted;
}

}  // namespace gabion
