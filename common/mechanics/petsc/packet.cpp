// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/petsc/packet.hpp"

#include <petscsys.h>

#include <cstdint>
#include <limits>
#include <string>

#include "common/mechanics/petsc/petsc_session.hpp"

namespace gabion {

namespace {

constexpr int message_tag = 7302;

// How long the message of each rank is that has one for this rank.
std::map<int, std::int64_t> sizes_of_incoming(MPI_Comm comm, const Packets& out) {
  std::vector<PetscMPIInt> to;
  std::vector<std::int64_t> sizes;
  for (const auto& [rank, packet] : out) {
    const auto size = std::ssize(packet.bytes());
    require(size <= std::numeric_limits<int>::max(),
            "found a message of " + std::to_string(size) +
                " bytes to another rank, allowed: below 2 GiB");
    to.push_back(rank);
    sizes.push_back(size);
  }
  PetscMPIInt num_from = 0;
  PetscMPIInt* from = nullptr;
  std::int64_t* from_sizes = nullptr;
  check_petsc(PetscCommBuildTwoSided(comm, 1, MPI_INT64_T, static_cast<PetscMPIInt>(to.size()),
                                     to.data(), sizes.data(), &num_from, &from, &from_sizes),
              "PetscCommBuildTwoSided");
  std::map<int, std::int64_t> incoming;
  for (PetscMPIInt k = 0; k < num_from; ++k) incoming[from[k]] = from_sizes[k];
  check_petsc(PetscFree(from), "PetscFree");
  check_petsc(PetscFree(from_sizes), "PetscFree");
  return incoming;
}

}  // namespace

Packets send_packets(MPI_Comm comm, const Packets& out) {
  const auto incoming = sizes_of_incoming(comm, out);
  std::map<int, std::vector<char>> bytes;
  std::vector<MPI_Request> requests;
  for (const auto& [rank, size] : incoming) {
    std::vector<char>& buffer = bytes[rank];
    buffer.resize(static_cast<std::size_t>(size));
    MPI_Irecv(buffer.data(), static_cast<int>(size), MPI_CHAR, rank, message_tag, comm,
              &requests.emplace_back());
  }
  for (const auto& [rank, packet] : out) {
    const auto given = packet.bytes();
    MPI_Isend(given.data(), static_cast<int>(given.size()), MPI_CHAR, rank, message_tag, comm,
              &requests.emplace_back());
  }
  MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
  Packets in;
  for (auto& [rank, buffer] : bytes) in.emplace(rank, Packet(std::move(buffer)));
  return in;
}

}  // namespace gabion
