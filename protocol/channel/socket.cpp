// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/channel/socket.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>
#include <utility>
#include <zmq.hpp>

#include "common/base/require.hpp"
#include "protocol/channel/authenticator.hpp"
#include "protocol/channel/local_channel.hpp"
#include "protocol/wire/codec.hpp"

namespace gabion {

namespace {

using Clock = std::chrono::steady_clock;

/// Addresses of IPv6 stand in brackets.
bool is_ipv6(const std::string& endpoint) {
  return endpoint.find('[') != std::string::npos;
}

int milliseconds_until(Clock::time_point end) {
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - Clock::now());
  return static_cast<int>(std::max<std::int64_t>(0, left.count()));
}

/// The message that is there, or nothing.
std::optional<RawMessage> take_from(zmq::socket_t& socket) {
  zmq::message_t part;
  if (!socket.recv(part, zmq::recv_flags::dontwait)) return std::nullopt;
  RawMessage frames;
  frames.push_back(part.to_string());
  while (part.more()) {
    // The parts of a message arrive together: this does not wait.
    if (!socket.recv(part, zmq::recv_flags::dontwait)) break;
    if (frames.size() < Socket::max_frames) frames.push_back(part.to_string());
  }
  return frames;
}

}  // namespace

struct SocketContext {
  zmq::context_t context{1};
};

struct Socket::Implementation {
  std::shared_ptr<SocketContext> context;  // declared first: destroyed after the socket
  std::unique_ptr<Authenticator> authenticator;
  zmq::socket_t socket;
  std::optional<zmq::socket_t> monitor;  // reports failed handshakes, until a message has come
  bool has_keys = false;
  int linger = 500;                       // [ms]
  std::optional<LocalListener> listener;  // the coupler's, beside the socket
  std::optional<LocalConnection> local;   // the participant's, instead of the socket
  std::string endpoint, route;            // endpoint of a local channel that is still to be tried

  Implementation(std::shared_ptr<SocketContext> shared, zmq::socket_type type)
      : context(std::move(shared)), socket(context->context, type) {
    socket.set(zmq::sockopt::linger, 500);
    socket.set(zmq::sockopt::sndtimeo, 1000);
    socket.set(zmq::sockopt::maxmsgsize, static_cast<std::int64_t>(CodecLimits{}.max_frame_bytes));
  }

  ~Implementation() {
    const auto end = Clock::now() + std::chrono::milliseconds(linger);
    while (has_unsent() && Clock::now() < end) flush();
  }
  Implementation(Implementation&&) = delete;
  Implementation& operator=(Implementation&&) = delete;
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  /// Try the local channel when the first message is sent.
  void try_local() {
    if (endpoint.empty()) return;
    local = LocalConnection::connect(std::exchange(endpoint, {}), max_frames);
    if (local) local->send({route});
  }

  bool has_unsent() const {
    return (listener && listener->has_unsent()) || (local && local->has_unsent());
  }

  void flush() {
    if (listener) listener->flush();
    if (local) local->flush();
  }

  /// Send the remaining bytes, and take a message that is there. A participant that computes sends
  /// nothing: its answer goes out before it gets a new request.
  std::optional<RawMessage> take() {
    flush();
    std::optional<RawMessage> message;
    if (listener) message = listener->take();
    if (local && !local->has_unsent()) message = local->take();
    return message ? message : take_from(socket);
  }

  /// Wait until something may have come, or can be sent. @returns false after `milliseconds`
  /// without
  bool wait(int milliseconds) {
    std::vector<zmq::pollitem_t> items = {{socket.handle(), 0, ZMQ_POLLIN, 0}};
    const auto add = [&items](int descriptor, bool unsent) {
      const int events = unsent ? ZMQ_POLLIN | ZMQ_POLLOUT : ZMQ_POLLIN;
      items.push_back({nullptr, descriptor, static_cast<short>(events), 0});
    };
    if (listener) {
      for (const auto& [descriptor, unsent] : listener->descriptors()) add(descriptor, unsent);
    }
    if (local && !local->is_closed()) add(local->descriptor(), local->has_unsent());
    return zmq::poll(items, std::chrono::milliseconds(milliseconds)) > 0;
  }

  void use(const ServerKeys& keys) {
    authenticator = std::make_unique<Authenticator>(context->context, keys.clients);
    socket.set(zmq::sockopt::zap_domain, "gabion");
    socket.set(zmq::sockopt::curve_server, true);
    socket.set(zmq::sockopt::curve_secretkey, keys.secret);
  }

  void use(const ClientKeys& keys) {
    has_keys = true;
    socket.set(zmq::sockopt::curve_serverkey, keys.coupler_public);
    socket.set(zmq::sockopt::curve_publickey, keys.own_public);
    socket.set(zmq::sockopt::curve_secretkey, keys.secret);
  }

  void start_monitor() {
    const std::string address = fmt::format("inproc://handshake-{}", fmt::ptr(this));
    const int events = ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL | ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL |
                       ZMQ_EVENT_HANDSHAKE_FAILED_AUTH;
    require<ProtocolError>(zmq_socket_monitor(socket.handle(), address.c_str(), events) == 0,
                           "the connection cannot be monitored");
    monitor.emplace(context->context, zmq::socket_type::pair);
    monitor->set(zmq::sockopt::linger, 0);
    monitor->connect(address);
  }

  void stop_monitor() {
    if (!monitor) return;
    zmq_socket_monitor(socket.handle(), nullptr, 0);
    monitor.reset();
  }
};

std::shared_ptr<SocketContext> make_socket_context() {
  return std::make_shared<SocketContext>();
}

Socket::Socket(std::unique_ptr<Implementation> implementation)
    : implementation_(std::move(implementation)) {}
Socket::~Socket() = default;
Socket::Socket(Socket&&) noexcept = default;
Socket& Socket::operator=(Socket&&) noexcept = default;

Socket Socket::bind_router(std::shared_ptr<SocketContext> context, const std::string& endpoint,
                           const std::optional<ServerKeys>& keys) {
  auto made = std::make_unique<Implementation>(std::move(context), zmq::socket_type::router);
  made->socket.set(zmq::sockopt::router_mandatory, true);
  made->socket.set(zmq::sockopt::ipv6, is_ipv6(endpoint));
  if (keys) made->use(*keys);
  try {
    made->socket.bind(endpoint);
  } catch (const zmq::error_t& problem) {
    throw ConfigError(
        fmt::format("cannot listen on \"{}\": {} (option protocol/endpoint; "
                    "tcp://127.0.0.1:* takes any free port)",
                    endpoint, problem.what()));
  }
  if (!keys) {
    const std::string bound = made->socket.get(zmq::sockopt::last_endpoint);
    made->listener = LocalListener::listen(bound, max_frames);
  }
  return Socket(std::move(made));
}

Socket Socket::connect_dealer(std::shared_ptr<SocketContext> context, const std::string& endpoint,
                              const std::string& route, int linger,
                              const std::optional<ClientKeys>& keys) {
  auto made = std::make_unique<Implementation>(std::move(context), zmq::socket_type::dealer);
  made->socket.set(zmq::sockopt::routing_id, route);
  made->socket.set(zmq::sockopt::linger, linger);
  made->socket.set(zmq::sockopt::ipv6, is_ipv6(endpoint));
  if (keys) made->use(*keys);
  made->linger = linger;
  if (linger > 0) made->start_monitor();  // nobody asks the others
  if (linger > 0 && !keys) {
    made->endpoint = endpoint;
    made->route = route;
  }
  try {
    made->socket.connect(endpoint);
  } catch (const zmq::error_t& problem) {
    throw ProtocolError(fmt::format(
        "cannot connect to the coupler at \"{}\": {} (expected such as tcp://127.0.0.1:5555)",
        endpoint, problem.what()));
  }
  return Socket(std::move(made));
}

bool Socket::send(const std::vector<std::string_view>& frames) {
  return send(frames, true);
}

bool Socket::try_send(const std::vector<std::string_view>& frames) {
  return send(frames, false);
}

bool Socket::send(const std::vector<std::string_view>& frames, bool waits) {
  Implementation& own = *implementation_;
  own.try_local();
  // The loss of the coupler is noticed by PeerWatch, as over the network.
  if (own.local) {
    own.local->send(frames);
    return true;
  }
  if (own.listener && own.listener->has(frames[0])) return own.listener->send(frames);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    auto flags = i + 1 < frames.size() ? zmq::send_flags::sndmore : zmq::send_flags::none;
    if (!waits) flags = flags | zmq::send_flags::dontwait;
    for (;;) {
      try {
        if (!own.socket.send(zmq::buffer(frames[i]), flags)) return false;
        break;
      } catch (const zmq::error_t& problem) {
        if (problem.num() == EHOSTUNREACH) return false;
        if (problem.num() != EINTR) throw ProtocolError(fmt::format("send: {}", problem.what()));
      }
    }
  }
  return true;
}

std::optional<std::vector<std::string>> Socket::receive(int milliseconds,
                                                        std::chrono::duration<double> look) {
  Implementation& own = *implementation_;
  const auto begin = Clock::now();
  const auto end = begin + std::chrono::milliseconds(milliseconds);
  const auto end_of_look = std::min(end, begin + std::chrono::ceil<Clock::duration>(look));
  try {
    for (;;) {
      if (auto message = own.take()) {
        own.stop_monitor();
        return message;
      }
      if (Clock::now() < end_of_look) {
        std::this_thread::yield();  // give the processor to other threads
        continue;
      }
      const int left = milliseconds_until(end);
      if (left == 0 || !own.wait(left)) return std::nullopt;
    }
  } catch (const zmq::error_t& problem) {
    if (problem.num() == EINTR) return std::nullopt;
    throw ProtocolError(fmt::format("receive: {}", problem.what()));
  }
}

/// Events: a 16-bit kind and a 32-bit value, then the address (zmq_socket_monitor).
std::optional<Socket::Refusal> Socket::refusal() {
  std::optional<Refusal> last;
  if (!implementation_->monitor) return last;
  zmq::message_t event;
  zmq::message_t address;
  while (implementation_->monitor->recv(event, zmq::recv_flags::dontwait) &&
         implementation_->monitor->recv(address, zmq::recv_flags::dontwait)) {
    std::uint16_t kind = 0;
    std::uint32_t value = 0;
    std::memcpy(&kind, event.data(), sizeof kind);
    std::memcpy(&value, event.data<char>() + sizeof kind, sizeof value);
    if (kind == ZMQ_EVENT_HANDSHAKE_FAILED_AUTH) {
      last = {
          "it does not know this participant's key: its public key must be in the coupler's "
          "protocol/security/clients_file",
          true};
    } else if (kind == ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL &&
               value == ZMQ_PROTOCOL_ERROR_ZMTP_MECHANISM_MISMATCH) {
      last = {implementation_->has_keys
                  ? "it uses no keys, this participant does (--key-file, --coupler-key-file)"
                  : "it takes participants with keys only (--key-file, --coupler-key-file)",
              true};
    } else {
      last = {
          implementation_->has_keys
              ? "it closes the connection when keys are exchanged: perhaps --coupler-key-file is "
                "not its public key, or it uses no keys"
              : "it closes the connection at once: perhaps it takes participants with keys only "
                "(--key-file, --coupler-key-file)",
          false};
    }
  }
  return last;
}

bool Socket::is_local(const std::string& route) const {
  return implementation_->listener && implementation_->listener->has(route);
}

std::string Socket::endpoint() const {
  return implementation_->socket.get(zmq::sockopt::last_endpoint);
}

}  // namespace gabion
