// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <cstdint>
#include <span>

#include "common/mechanics/tensor.hpp"

namespace gabion {

/// MPI_COMM_NULL stands for a process that is alone, with MPI or without.
inline int num_ranks(MPI_Comm comm) {
  int size = 1;
  if (comm != MPI_COMM_NULL) MPI_Comm_size(comm, &size);
  return size;
}

inline int rank_of(MPI_Comm comm) {
  int rank = 0;
  if (comm != MPI_COMM_NULL) MPI_Comm_rank(comm, &rank);
  return rank;
}

/// Replace each value by its sum over the ranks. Collective; costs nothing on one rank.
inline void sum_over_ranks(MPI_Comm comm, std::span<double> values) {
  if (num_ranks(comm) == 1) return;
  MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_DOUBLE, MPI_SUM,
                comm);
}

inline void sum_over_ranks(MPI_Comm comm, std::span<std::int32_t> values) {
  if (num_ranks(comm) == 1) return;
  MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_INT32_T, MPI_SUM,
                comm);
}

template <int dim>
void sum_over_ranks(MPI_Comm comm, std::span<Vector<dim>> values) {
  if (values.empty()) return;
  sum_over_ranks(comm, std::span<double>(values.front().data(), values.size() * dim));
}

/// Replace each value by the largest over the ranks. Collective.
inline void max_over_ranks(MPI_Comm comm, std::span<double> values) {
  if (num_ranks(comm) == 1) return;
  MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_DOUBLE, MPI_MAX,
                comm);
}

inline void max_over_ranks(MPI_Comm comm, std::span<std::int32_t> values) {
  if (num_ranks(comm) == 1) return;
  MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_INT32_T, MPI_MAX,
                comm);
}

/// Largest value over the ranks. Collective.
inline double max_over_ranks(MPI_Comm comm, double value) {
  if (num_ranks(comm) > 1) MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_MAX, comm);
  return value;
}

}  // namespace gabion
