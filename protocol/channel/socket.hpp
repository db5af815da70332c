// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/channel/keys.hpp"

namespace gabion {

/// State of the messaging library in one process; sockets of several threads share it.
struct SocketContext;
/// Make a context; it is shared, because it must outlive the last socket.
std::shared_ptr<SocketContext> make_socket_context();

/// A ZeroMQ socket with finite linger and finite send time. To be used by one thread at a time.
/// Between processes of one machine messages use local_channel.hpp, which wakes no threads of the
/// library: this needs no keys on either side, one endpoint, and a coupler that is there when the
/// participant sends its first message.
class Socket {
 public:
  /// Coupler's side. The first frame of what it sends and receives is the peer's route.
  /// @param keys  only participants with one of these keys may connect, and all is encrypted
  /// @throws ConfigError  the endpoint cannot be bound
  static Socket bind_router(std::shared_ptr<SocketContext> context, const std::string& endpoint,
                            const std::optional<ServerKeys>& keys = {});
  /// Participant's side. Connects in the background, again and again.
  /// @param route   unique to this socket, at most 255 bytes
  /// @param linger  [ms] that closing waits for unsent messages
  /// @throws ProtocolError  the endpoint is not understood
  static Socket connect_dealer(std::shared_ptr<SocketContext> context, const std::string& endpoint,
                               const std::string& route, int linger = 500,
                               const std::optional<ClientKeys>& keys = {});
  ~Socket();
  Socket(Socket&&) noexcept;
  Socket& operator=(Socket&&) noexcept;
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  /// False when the peer cannot be reached or its queue stays full for a second.
  bool send(const std::vector<std::string_view>& frames);
  /// Like send(), without waiting: false also when the queue is full now.
  bool try_send(const std::vector<std::string_view>& frames);

  /// One message, or nothing after `milliseconds` or when a signal came.
  /// Only the first `max_frames` frames of a message are kept.
  /// @param look  time of polling before sleep (Attention)
  std::optional<std::vector<std::string>> receive(int milliseconds,
                                                  std::chrono::duration<double> look = {});

  /// Reason why the coupler does not admit a participant, known until its first message comes.
  struct Refusal {
    std::string reason;
    bool is_final = false;  ///< trying again will not help
  };
  std::optional<Refusal> refusal();

  /// Whether messages to this route stay on this machine, without the network. Coupler's side.
  bool is_local(const std::string& route) const;

  /// Endpoint to which the socket is bound, with the port that it got when `*` was asked for.
  std::string endpoint() const;

  static constexpr std::size_t max_frames = 300;

 private:
  struct Implementation;
  bool send(const std::vector<std::string_view>& frames, bool waits);
  explicit Socket(std::unique_ptr<Implementation> implementation);
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace gabion
