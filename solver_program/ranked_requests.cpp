// SPDX-License-Identifier: BSD-3-Clause
#include "solver_program/ranked_requests.hpp"

#include <chrono>
#include <cstdint>
#include <span>
#include <thread>

#include "common/mechanics/ranks/sum.hpp"
#include "protocol/wire/codec.hpp"

namespace gabion {

namespace {

using Frames = std::vector<std::string>;

/// Broadcast from rank 0 while the receivers sleep, so that the core of a rank that waits is free
/// for another program.
void broadcast_asleep(MPI_Comm comm, std::int64_t& value) {
  constexpr int eager_tests = 100;
  constexpr auto nap = std::chrono::microseconds(50);
  MPI_Request request;
  MPI_Ibcast(&value, 1, MPI_INT64_T, 0, comm, &request);
  int done = 0;
  for (int tests = 0; MPI_Test(&request, &done, MPI_STATUS_IGNORE), !done; ++tests) {
    if (tests >= eager_tests) std::this_thread::sleep_for(nap);
  }
}

/// The frames of a request, or none and the error that ends the ranks. A frame has at most 1 GiB.
void broadcast_frames(MPI_Comm comm, Frames& frames, std::string& error) {
  auto count = static_cast<std::int64_t>(frames.size());
  broadcast_asleep(comm, count);
  frames.resize(count);
  std::vector<std::string*> parts;
  for (std::string& frame : frames) parts.push_back(&frame);
  if (frames.empty()) parts.push_back(&error);
  std::vector<int> sizes;
  for (const std::string* part : parts) sizes.push_back(static_cast<int>(part->size()));
  MPI_Bcast(sizes.data(), static_cast<int>(sizes.size()), MPI_INT, 0, comm);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    parts[i]->resize(sizes[i]);
    MPI_Bcast(parts[i]->data(), sizes[i], MPI_BYTE, 0, comm);
  }
}

}  // namespace

void end_followers(MPI_Comm comm, const std::string& error) {
  if (num_ranks(comm) == 1) return;
  Frames none;
  std::string text = error;
  broadcast_frames(comm, none, text);
}

Message LeadingRequests::next_request(Frames* frames) {
  if (num_ranks(comm_) == 1) return source_.next_request(frames);
  Frames own;
  Message request;
  try {
    request = source_.next_request(&own);
  } catch (const std::exception& problem) {
    end_followers(comm_, problem.what());
    throw;
  }
  std::string no_error;
  broadcast_frames(comm_, own, no_error);
  finished_ = request.type == "finish";
  if (frames) *frames = std::move(own);
  return request;
}

void LeadingRequests::reply(Message message) {
  try {
    source_.reply(std::move(message));
  } catch (const std::exception& problem) {
    if (!finished_) end_followers(comm_, problem.what());  // else they wait for nothing
    throw;
  }
}

Message FollowingRequests::next_request(Frames* frames) {
  Frames own;
  std::string error;
  broadcast_frames(comm_, own, error);
  if (own.empty()) throw ProtocolError("rank 0 failed: " + error);
  Message request = decode(std::span<const std::string>(own));
  if (frames) *frames = std::move(own);
  return request;
}

}  // namespace gabion
