// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>
#include <petscsf.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/mechanics/petsc/petsc_handle.hpp"

namespace gabion {

/// Exchange of rows of values by their numbers, from the ranks that have them to those that want
/// them, such as those of a checkpoint that is read on another number of ranks. Each row passes
/// through the rank that an even division of the numbers names (two star forests of PETSc), so no
/// rank has all.
class NumberedValues {
 public:
  /// @param given   numbers of the rows that this rank has, in any order
  /// @param wanted  numbers of those that it wants, in any order
  /// @param end     behind the last number of all
  /// @param what    text that says what the numbers are, for errors
  /// @throws Error  a number from 0 to end - 1 that no rank has, or several; on all ranks
  /// @note Collective.
  NumberedValues(MPI_Comm comm, std::span<const std::int64_t> given,
                 std::span<const std::int32_t> wanted, std::int32_t end, std::string what);

  /// @param given  num_given x width
  /// @returns      num_wanted x width
  /// @note Collective.
  std::vector<double> send(std::span<const double> given, int width) const;

 private:
  using Forest = PetscHandle<PetscSF, PetscSFDestroy>;
  void require_each_once(std::span<const std::int64_t> given) const;

  MPI_Comm comm_;
  std::string what_;
  Forest from_, to_;
  std::size_t num_roots_ = 0, num_wanted_ = 0;
};

}  // namespace gabion
