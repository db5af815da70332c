// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <set>
#include <string>
#include <thread>
#include <zmq.hpp>

#include "protocol/channel/strangers.hpp"

namespace gabion {

/// Decides who may connect to a context (ZAP 1.0: ZeroMQ RFC 27), in a thread of its own, so that
/// no handshake waits for the coupler or delays it. There is one for each context, made before any
/// socket binds.
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
  Strangers strangers_;  // senders without access, by key
  std::atomic<bool> stopping_ = false;
  std::thread thread_;  // last: starts when all members are there
};

}  // namespace gabion
