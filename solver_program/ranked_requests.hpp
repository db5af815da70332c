// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <string>
#include <vector>

#include "protocol/participant/request_source.hpp"

namespace gabion {

/// The coupler's requests on the first rank of a solver, which passes them on to the other ranks
/// byte by byte before it does them. Only this rank replies.
class LeadingRequests final : public RequestSource {
 public:
  /// @param source  outlives this
  LeadingRequests(MPI_Comm comm, RequestSource& source) : comm_(comm), source_(source) {}

  /// A failure of the source ends the other ranks too.
  Message next_request(std::vector<std::string>* frames) override;
  void reply(Message message) override;

 private:
  MPI_Comm comm_;
  RequestSource& source_;
  bool finished_ = false;
};

/// The coupler's requests on every other rank, which sleeps until the next one comes. Replies go
/// nowhere.
class FollowingRequests final : public RequestSource {
 public:
  explicit FollowingRequests(MPI_Comm comm) : comm_(comm) {}

  /// @throws ProtocolError  the first rank failed
  Message next_request(std::vector<std::string>* frames) override;
  void reply(Message) override {}

 private:
  MPI_Comm comm_;
};

/// End the other ranks with this error. The first rank calls this when no further request will
/// come.
void end_followers(MPI_Comm comm, const std::string& error);

}  // namespace gabion
