// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <numeric>
#include <span>
#include <type_traits>
#include <vector>

#include "common/mechanics/ranks/sum.hpp"

namespace gabion {

template <class Value>
MPI_Datatype mpi_type() {
  if constexpr (std::is_same_v<Value, double>) {
    return MPI_DOUBLE;
  } else if constexpr (std::is_same_v<Value, std::int64_t>) {
    return MPI_INT64_T;
  } else {
    static_assert(std::is_same_v<Value, std::uint8_t>);
    return MPI_BYTE;
  }
}

/// Start of each rank's values, and the number of all of them.
inline std::vector<int> starts_of(const std::vector<int>& counts) {
  std::vector<int> starts(counts.size() + 1, 0);
  std::partial_sum(counts.begin(), counts.end(), starts.begin() + 1);
  return starts;
}

/// The values of all ranks one after the other, on the first rank; elsewhere nothing. Collective.
/// @param[out] counts  values of each rank, on the first one
template <class Value>
std::vector<Value> gather(MPI_Comm comm, std::span<const Value> own, std::vector<int>& counts) {
  const int count = static_cast<int>(own.size());
  counts.assign(num_ranks(comm), count);
  if (num_ranks(comm) == 1) return {own.begin(), own.end()};
  MPI_Gather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, comm);
  const std::vector<int> starts = starts_of(counts);
  std::vector<Value> all(rank_of(comm) == 0 ? starts.back() : 0);
  MPI_Gatherv(own.data(), count, mpi_type<Value>(), all.data(), counts.data(), starts.data(),
              mpi_type<Value>(), 0, comm);
  return all;
}

template <class Value>
std::vector<Value> gather(MPI_Comm comm, std::span<const Value> own) {
  std::vector<int> counts;
  return gather(comm, own, counts);
}

/// Like gather(), with the result on all ranks.
template <class Value>
std::vector<Value> gather_on_all(MPI_Comm comm, std::span<const Value> own) {
  const int count = static_cast<int>(own.size());
  std::vector<int> counts(num_ranks(comm), count);
  if (num_ranks(comm) == 1) return {own.begin(), own.end()};
  MPI_Allgather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, comm);
  const std::vector<int> starts = starts_of(counts);
  std::vector<Value> all(starts.back());
  MPI_Allgatherv(own.data(), count, mpi_type<Value>(), all.data(), counts.data(), starts.data(),
                 mpi_type<Value>(), comm);
  return all;
}

}  // namespace gabion
