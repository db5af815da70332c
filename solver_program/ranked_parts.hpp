// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <cstdint>
#include <functional>
#include <string>

#include "common/run/state.hpp"

namespace gabion {

/// Layout of the states of all ranks in one state, whose arrays hold those of the ranks one after
/// the other: "ranks", their number; "facts" of each; "reals", "integers": by array the number of
/// values of each; "lists", see State::lists.
/// @param own  of this rank; equal names on all ranks
/// @returns    on the first rank; null on the others
/// @note Collective.
Json gather_parts(MPI_Comm comm, const State& own);

/// Number of values of an array, by "reals" or "integers" and its name; negative: it is missing.
using ArraySize = std::function<std::int64_t(const std::string& kind, const std::string& name)>;

/// @throws Error  not what gather_parts() made of arrays of these sizes
void check_parts(const Json& parts, const ArraySize& size);

/// Send a value from the first rank to all. @note Collective.
Json broadcast(MPI_Comm comm, const Json& value);

}  // namespace gabion
