// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include "common/run/solver.hpp"

namespace gabion {

/// The parts of all ranks in one state: each array holds those of the ranks one after the other.
/// @param own  of this rank; equal names on all ranks
/// @returns    on the first rank; empty on the others
/// @note Collective.
State gather_state(MPI_Comm comm, State own);

/// The part of this rank, from what gather_state() made.
/// @param all  read on the first rank only
/// @throws ConfigError  gathered from another number of ranks; on all ranks, with both numbers
/// @note Collective.
State scatter_state(MPI_Comm comm, const State& all);

/// @throws ConfigError  the run has another number of ranks than that which saved its state
void require_ranks(MPI_Comm comm, int saved_ranks);

/// Let the solver continue from what gather_state() made: from its own part, or, where that was
/// made by another number of ranks, from all parts if it can join them.
/// @param all  read on the first rank only
/// @throws ConfigError  another number of ranks, and the solver cannot join states
/// @note Collective.
void load_gathered(MPI_Comm comm, const State& all, Solver& solver);

}  // namespace gabion
