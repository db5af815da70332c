// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <mutex>
#include <optional>
#include <string>

#include "common/base/process.hpp"

namespace gabion {

/// Signs of life of one peer. Safe to use from several threads.
class PeerWatch {
 public:
  /// @param label  for messages: `participant "structure" (fem_solver, pid 123)`
  PeerWatch(std::string label, ProcessIdentity process);

  const std::string& label() const { return label_; }

  /// Note that a message came from the peer.
  void sign_of_life();
  /// Note a heartbeat, which names the phase of the peer.
  void sign_of_life(const std::string& phase);
  /// Note that the peer was asked to do this; empty = it has answered.
  void asked(const std::string& what);
  /// The request that it has not answered yet; empty = none.
  std::string question() const;
  /// Count the peer's silence from now on, because this process itself slept.
  void forgive();

  /// A sentence when the peer's process on this machine has ended.
  std::optional<std::string> death() const;
  /// A sentence when nothing came for `deadline` seconds.
  std::optional<std::string> silence(double deadline) const;
  /// `last sign of life 0.3 s ago in phase "solve_step 57 iteration 3"`
  std::string last_words() const;

 private:
  using Clock = std::chrono::steady_clock;
  double seconds_since(Clock::time_point when) const;

  std::string label_;
  ProcessIdentity process_;
  mutable std::mutex mutex_;
  Clock::time_point last_sign_;
  Clock::time_point silent_from_;
  std::string phase_ = "handshake";
  std::string asked_;
};

}  // namespace gabion
