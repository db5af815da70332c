// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/socket.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>
#include <zmq.hpp>

#include "common/base/require.hpp"
#include "protocol/authenticator.hpp"
#include "protocol/codec.hpp"

namespace gabion {

namespace {

/// First part of a message that is there or comes within this time; the processor goes to whoever
/// else wants it. @returns whether one came.
bool look_for(zmq::socket_t& socket, zmq::message_t& part, std::chrono::duration<double> time) {
  const auto until = std::chrono::steady_clock::now() + time;
  do {
    if (socket.recv(part, zmq::recv_flags::dontwait)) return true;
    std::this_thread::yield();
  } while (std::chrono::steady_clock::now() < until);
  return false;
}

}  // namespace

struct SocketContext {
  zmq::context_t context{1};
};

struct Socket::Implementation {
  std::shared_ptr<SocketContext> context;  // declared first: destroyed after the socket
  std::unique_ptr<Authenticator> authenticator;
  zmq::socket_t socket;
  std::optional<zmq::socket_t> monitor;  // of failed handshakes, until a message has come
  bool has_keys = false;

  Implementation(std::shared_ptr<SocketContext> shared, zmq::socket_type type)
      : context(std::move(shared)), socket(context->context, type) {
    socket.set(zmq::sockopt::linger, 500);
    socket.set(zmq::sockopt::sndtimeo, 1000);
    socket.set(zmq::sockopt::maxmsgsize, static_cast<std::int64_t>(CodecLimits{}.max_frame_bytes));
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
  if (keys) made->use(*keys);
  try {
    made->socket.bind(endpoint);
  } catch (const zmq::error_t& problem) {
    throw ProtocolError(
        fmt::format("cannot listen on \"{}\": {} (option protocol/endpoint; "
                    "tcp://127.0.0.1:* takes any free port)",
                    endpoint, problem.what()));
  }
  return Socket(std::move(made));
}

Socket Socket::connect_dealer(std::shared_ptr<SocketContext> context, const std::string& endpoint,
                              const std::string& route, int linger,
                              const std::optional<ClientKeys>& keys) {
  auto made = std::make_unique<Implementation>(std::move(context), zmq::socket_type::dealer);
  made->socket.set(zmq::sockopt::routing_id, route);
  made->socket.set(zmq::sockopt::linger, linger);
  if (keys) made->use(*keys);
  if (linger > 0) made->start_monitor();  // nobody asks the others
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
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto flags = i + 1 < frames.size() ? zmq::send_flags::sndmore : zmq::send_flags::none;
    for (;;) {
      try {
        if (!implementation_->socket.send(zmq::buffer(frames[i]), flags)) return false;
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
  zmq::socket_t& socket = implementation_->socket;
  try {
    zmq::message_t part;
    const std::chrono::milliseconds patience(milliseconds);
    if (!look_for(socket, part, std::min<std::chrono::duration<double>>(look, patience))) {
      if (milliseconds == 0) return std::nullopt;
      zmq::pollitem_t item{socket.handle(), 0, ZMQ_POLLIN, 0};
      if (zmq::poll(&item, 1, std::chrono::milliseconds(milliseconds)) == 0) return std::nullopt;
      if (!socket.recv(part, zmq::recv_flags::dontwait)) return std::nullopt;
    }
    implementation_->stop_monitor();
    std::vector<std::string> frames;
    frames.push_back(part.to_string());
    while (part.more()) {
      // The parts of a message arrive together: this does not wait.
      if (!socket.recv(part, zmq::recv_flags::dontwait)) break;
      if (frames.size() < max_frames) frames.push_back(part.to_string());
    }
    return frames;
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
          "it does not know this participant's key: its public key has to stand in the "
          "coupler's protocol/security/clients_file",
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

std::string Socket::endpoint() const {
  return implementation_->socket.get(zmq::sockopt::last_endpoint);
}

}  // namespace gabion
