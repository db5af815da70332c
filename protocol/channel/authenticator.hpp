// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <set>
#include <string>
#include <thread>
#include <zmq.hpp>

#include "protocol/channel/strangers.hpp"

namespace gabion {

/// Answers for a context who may connect (ZAP 1.0: ZeroMQ RFC 27), in a thread of its own, so that
/// nobody's handshake waits for the coupler or holds it up. One a context, before any socket binds.
class Authenticator {
 public:
  /// @param clients  public keys of those that may
  Authenticator(zmq::context_t& context, std::set<std::string> clients);
  ~Authenticator();
  Authenticator(const Authenticator&) = delete;
  Authenticator& operator=(const Authenticator&) = delete;
  Authenticator(Authenticator&&) = delete;
  Authenticator& operator=(Authenticator&&) = delete;

 private:
  void run();
  void answer_one();

  std::set<std::string> clients_;
  zmq::socket_t socket_;
  Strangers strangers_;  // by key
  std::atomic<bool> stopping_ = false;
  std::thread thread_;  // last: starts when all else is there
};

}  // namespace gabion
