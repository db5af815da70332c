// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <cstdint>
#include <span>
#include <vector>

namespace gabion {

/// The rows of a file of all points (or nodes, or cells), ordered by number, in as many shares as
/// there are ranks: each takes the numbers of an equal count of chunks of the file. So the order
/// does not depend on which rank has which points, and no rank has all of them.
class NumberedRows {
 public:
  /// @param numbers  of the points of this rank, ascending; no other rank has one of them
  /// @param end      behind the last one of all ranks
  /// @note Collective.
  NumberedRows(MPI_Comm comm, std::span<const std::int64_t> numbers, std::int64_t end);

  /// Turns values of the points of this rank into those of its rows.
  /// @param own    num_points x width
  /// @returns      num_rows x width
  /// @note Collective.
  std::vector<double> gather_rows(std::vector<double> own, int width) const;
  std::vector<std::int32_t> gather_rows(std::vector<std::int32_t> own, int width) const;

 private:
  template <class Value>
  std::vector<Value> exchange(std::span<const Value> own, std::size_t width) const;
  template <class Value>
  std::vector<Value> gather(std::vector<Value> own, int width) const;

  MPI_Comm comm_;
  std::vector<std::int32_t> starts_;  // first point of this rank whose row each rank has
  std::vector<std::size_t> order_;    // of what arrives, in the order of ranks: ascending numbers
};

}  // namespace gabion
