// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <string>

#include "common/run/solver.hpp"

namespace gabion {

/// Write the states of all ranks to a file as that of gather_state() would be (write_state), but
/// each rank writes its own: none has them all.
/// @param own  of this rank; equal names on all ranks
/// @throws Error  disk full, folder gone; on all ranks
/// @note Collective.
void write_ranked_state(MPI_Comm comm, const std::string& path, State own);

/// Let the solver continue from such a file: each rank reads its own part; where another number of
/// ranks wrote it, the parts of some of them.
/// @throws ConfigError  another number of ranks, and the solver cannot join states
/// @throws Error        damaged, or not such a file; on all ranks
/// @note Collective.
void load_ranked_state(MPI_Comm comm, const std::string& path, Solver& solver);

}  // namespace gabion
