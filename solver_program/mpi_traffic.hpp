// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

namespace gabion {

/// Messages of this process to other ranks, its own and PETSc's, and the time that it waited for
/// them. Those of MUMPS, which calls from Fortran, are not counted.
struct MpiTraffic {
  std::int64_t messages = 0;          ///< to one rank each
  std::int64_t message_bytes = 0;     ///< in them
  std::int64_t collectives = 0;       ///< calls in which all ranks take part
  std::int64_t collective_bytes = 0;  ///< that this rank gave to them
  double waiting_seconds = 0;         ///< in calls that need other ranks to return

  MpiTraffic& operator+=(const MpiTraffic& other);
};
MpiTraffic operator-(MpiTraffic a, const MpiTraffic& b);

/// Traffic since the start of the process. Empty where nobody counts: the library
/// gabion_mpi_counter has to be loaded before that of MPI (LD_PRELOAD).
std::optional<MpiTraffic> mpi_traffic();

}  // namespace gabion
