// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/ranks/packet.hpp"

#include <limits>
#include <string>

#include "common/mechanics/ranks/sum.hpp"

namespace gabion {

namespace {

constexpr int message_tag = 7302;

void require_length(const Packet& packet) {
  const auto size = std::ssize(packet.bytes());
  require(size <= std::numeric_limits<int>::max(),
          "found a message of " + std::to_string(size) +
              " bytes to another rank, allowed: below 2 GiB");
}

// Number of ranks that have a packet for this one. No rank knows it before all have asked, so that
// a message of one exchange is never taken for one of the next.
int count_incoming(MPI_Comm comm, const Packets& out) {
  std::vector<int> sent(num_ranks(comm), 0);
  for (const auto& [rank, packet] : out) sent[rank] = 1;
  int incoming = 0;
  MPI_Reduce_scatter_block(sent.data(), &incoming, 1, MPI_INT, MPI_SUM, comm);
  return incoming;
}

}  // namespace

Packets send_packets(MPI_Comm comm, const Packets& out) {
  for (const auto& [rank, packet] : out) require_length(packet);
  const int incoming = count_incoming(comm, out);
  std::vector<MPI_Request> requests;
  for (const auto& [rank, packet] : out) {
    const auto bytes = packet.bytes();
    MPI_Isend(bytes.data(), static_cast<int>(bytes.size()), MPI_CHAR, rank, message_tag, comm,
              &requests.emplace_back());
  }
  Packets in;
  for (int k = 0; k < incoming; ++k) {
    MPI_Status status;
    MPI_Probe(MPI_ANY_SOURCE, message_tag, comm, &status);
    int size = 0;
    MPI_Get_count(&status, MPI_CHAR, &size);
    std::vector<char> bytes(size);
    MPI_Recv(bytes.data(), size, MPI_CHAR, status.MPI_SOURCE, message_tag, comm, MPI_STATUS_IGNORE);
    in.emplace(status.MPI_SOURCE, Packet(std::move(bytes)));
  }
  MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
  return in;
}

}  // namespace gabion
