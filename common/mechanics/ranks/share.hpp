// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "common/mechanics/ranks/sum.hpp"

namespace gabion {

/// This rank's share of the rows that the ranks have together, one rank's after the other's.
struct RowShare {
  std::int64_t first = 0;
  std::int64_t count = 0;
  std::int64_t total = 0;  ///< sum over all ranks
};

/// @note Collective.
inline RowShare share_of_rows(MPI_Comm comm, std::int64_t count) {
  RowShare share{.first = 0, .count = count, .total = count};
  if (num_ranks(comm) == 1) return share;
  MPI_Exscan(&count, &share.first, 1, MPI_INT64_T, MPI_SUM, comm);
  if (rank_of(comm) == 0) share.first = 0;  // the standard leaves it undefined
  MPI_Allreduce(&count, &share.total, 1, MPI_INT64_T, MPI_SUM, comm);
  return share;
}

}  // namespace gabion
