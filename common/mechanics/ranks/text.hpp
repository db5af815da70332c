// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>

#include "common/base/error.hpp"
#include "common/mechanics/ranks/sum.hpp"

namespace gabion {

/// The text of the lowest rank that has one, on all ranks; empty when none has. Collective.
inline std::string first_text(MPI_Comm comm, std::string text) {
  const int size = num_ranks(comm);
  if (size == 1) return text;
  int speaker = text.empty() ? size : rank_of(comm);
  MPI_Allreduce(MPI_IN_PLACE, &speaker, 1, MPI_INT, MPI_MIN, comm);
  if (speaker == size) return {};
  int length = static_cast<int>(text.size());
  MPI_Bcast(&length, 1, MPI_INT, speaker, comm);
  text.resize(length);
  MPI_Bcast(text.data(), length, MPI_CHAR, speaker, comm);
  return text;
}

/// Do the work, which is not collective. @throws Failure  on all ranks what it threw on the lowest
/// one. @note Collective.
template <class Failure = Error>
void together(MPI_Comm comm, const std::function<void()>& work) {
  if (num_ranks(comm) == 1) return work();
  std::string problem;
  try {
    work();
  } catch (const Failure& error) {
    problem = error.what();
  }
  problem = first_text(comm, problem);
  if (!problem.empty()) throw Failure(problem);
}

}  // namespace gabion
