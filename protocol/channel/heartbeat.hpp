// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "common/base/timer.hpp"
#include "protocol/channel/peer_watch.hpp"
#include "protocol/channel/socket.hpp"

namespace gabion {

struct HeartbeatSettings {
  std::string endpoint;
  std::string route;
  std::string participant;
  std::string session;
  /// End this process when the coupler is lost while the solver computes.
  bool exit_when_coupler_is_lost = true;
  std::optional<ClientKeys> keys = {};
};

/// A thread of the participant with a socket of its own: tells the coupler every half second what
/// the participant does, also while the solver computes, and listens to the coupler's signs of
/// life.
class Heartbeat {
 public:
  Heartbeat(std::shared_ptr<SocketContext> context, const HeartbeatSettings& settings);
  ~Heartbeat();
  Heartbeat(const Heartbeat&) = delete;
  Heartbeat& operator=(const Heartbeat&) = delete;
  Heartbeat(Heartbeat&&) = delete;
  Heartbeat& operator=(Heartbeat&&) = delete;

  /// @param busy  the solver computes, so no other thread checks whether the coupler lives
  void set_phase(const std::string& phase, bool busy);
  /// Watch this coupler, after the handshake.
  /// @param interval  [s] between two signs of life
  void watch(std::shared_ptr<PeerWatch> coupler, double interval, double silence_deadline);

 private:
  void run();
  void send_alive();
  void receive_alive();
  void check_coupler(double slept);

  HeartbeatSettings settings_;
  Socket socket_;  // used by the thread only
  std::uint64_t num_beats_ = 0;
  Stopwatch since_loss_;
  bool lost_ = false;

  std::mutex mutex_;  // guards the following members
  std::condition_variable changed_;
  bool stopping_ = false;
  std::string phase_ = "handshake";
  bool busy_ = false;
  Stopwatch in_phase_;
  double interval_ = 0.5;
  double silence_deadline_ = 10;
  /// Shared with the connection, whose own waits look at it too.
  std::shared_ptr<PeerWatch> coupler_;

  std::thread thread_;  // last: starts when all members are there
};

}  // namespace gabion
