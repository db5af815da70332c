// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <list>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/descriptor.hpp"

namespace gabion {

/// A message as it comes from a socket, frame by frame.
using RawMessage = std::vector<std::string>;

/// One end of a stream between two processes of one user on one machine. A message is a count of
/// frames and their sizes (64-bit, in the machine's order), then their bytes. Bytes for which the
/// peer's buffer has no room are kept and sent by later calls. Nothing here waits longer than a
/// millisecond without progress.
class LocalConnection {
 public:
  /// @param max_frames  of a message; more is not understood
  LocalConnection(Descriptor end, std::size_t max_frames)
      : end_(std::move(end)), max_frames_(max_frames) {}

  /// Connect to the process that listens there; none where nobody does, or another user.
  static std::optional<LocalConnection> connect(const std::string& endpoint,
                                                std::size_t max_frames);

  /// False where the peer has closed.
  bool send(const std::vector<std::string_view>& frames);
  /// Send the remaining bytes, as far as the peer has room, and read arrived ones, so that the peer
  /// has room.
  void flush();
  /// The oldest message that has come in whole.
  std::optional<RawMessage> take();
  /// The peer has closed its end, or sent what is not understood: nothing more will come.
  bool is_closed() const { return closed_; }
  bool takes_messages() const { return !closed_ && !deaf_; }
  bool has_unsent() const { return takes_messages() && !unsent_.empty(); }
  int descriptor() const { return end_.number(); }

 private:
  void read();
  bool cut_message();
  bool refuse();
  std::size_t write(std::string_view bytes);

  Descriptor end_;
  std::size_t max_frames_;
  bool closed_ = false;
  bool deaf_ = false;  // earlier messages of the peer may still be there to read
  std::string unsent_;
  std::string came_;  // bytes of messages that are not complete yet
  std::deque<RawMessage> messages_;
};

/// The coupler's end: all connections, by the route that each gives in its first message.
class LocalListener {
 public:
  /// None where the machine has no such sockets or the name is taken: the other connection remains
  /// open.
  static std::optional<LocalListener> listen(const std::string& endpoint, std::size_t max_frames);

  /// Whether this route leads here, to a peer that has not closed.
  bool has(std::string_view route) const;
  /// False where the peer has closed. @param frames  the route first
  bool send(const std::vector<std::string_view>& frames);
  void flush();
  bool has_unsent() const;
  /// One message that has come, the route of its sender first.
  std::optional<RawMessage> take();
  /// Descriptors to wait for, and whether bytes are unsent there.
  std::map<int, bool> descriptors() const;

 private:
  LocalListener(Descriptor door, std::size_t max_frames)
      : door_(std::move(door)), max_frames_(max_frames) {}
  using Peers = std::map<std::string, LocalConnection, std::less<>>;
  void accept_all();
  void welcome_new();

  Descriptor door_;
  std::size_t max_frames_;
  std::list<LocalConnection> nameless_;
  Peers by_route_;
  std::string last_served_;
};

}  // namespace gabion
