// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/channel/local_channel.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <utility>

#include "protocol/wire/codec.hpp"

namespace gabion {

namespace {

constexpr int room_milliseconds = 1;  // for a peer that reads to make room
constexpr int waiting_peers = 64;     // between two polls
constexpr std::size_t word = sizeof(std::uint64_t);

// A socket that is bound or connected to the name of an endpoint; none where that fails or the
// name is too long. The name has no file and ends with its socket; each network namespace has its
// own names, as it has its own loopback.
// @param use  bind or connect
Descriptor socket_at(const std::string& endpoint, int (*use)(int, const sockaddr*, socklen_t)) {
  const std::string name = "gabion " + endpoint;
  sockaddr_un address{};
  if (name.size() + 1 > sizeof address.sun_path) return {};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path + 1, name.data(), name.size());
  const std::size_t size = offsetof(sockaddr_un, sun_path) + 1 + name.size();
  Descriptor made(socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!made.is_open()) return {};
  const auto* generic = reinterpret_cast<const sockaddr*>(&address);
  if (use(made.number(), generic, static_cast<socklen_t>(size)) != 0) return {};
  return made;
}

// Otherwise a process that binds the name first could act as the coupler of another user.
bool is_own_user(int descriptor) {
  ucred peer{};
  socklen_t size = sizeof peer;
  return getsockopt(descriptor, SOL_SOCKET, SO_PEERCRED, &peer, &size) == 0 &&
         peer.uid == geteuid();
}

void append_number(std::string& to, std::uint64_t number) {
  char bytes[word];
  std::memcpy(bytes, &number, word);
  to.append(bytes, word);
}

std::uint64_t number_at(const std::string& from, std::size_t place) {
  std::uint64_t number = 0;
  std::memcpy(&number, from.data() + place, word);
  return number;
}

}  // namespace

std::optional<LocalConnection> LocalConnection::connect(const std::string& endpoint,
                                                        std::size_t max_frames) {
  Descriptor end = socket_at(endpoint, ::connect);
  if (!end.is_open() || !is_own_user(end.number())) return std::nullopt;
  return LocalConnection(std::move(end), max_frames);
}

bool LocalConnection::send(const std::vector<std::string_view>& frames) {
  if (!takes_messages()) return false;
  std::string head;
  append_number(head, frames.size());
  for (const std::string_view frame : frames) append_number(head, frame.size());
  const auto put = [this](std::string_view bytes) {
    const std::size_t sent = unsent_.empty() ? write(bytes) : 0;
    unsent_.append(bytes.substr(sent));
  };
  // One call for what is short, no copy of what is long.
  constexpr std::size_t is_short = 65536;
  for (const std::string_view frame : frames) {
    if (head.size() + frame.size() <= is_short) {
      head.append(frame);
      continue;
    }
    put(head);
    head.clear();
    put(frame);
  }
  if (!head.empty()) put(head);
  return takes_messages();
}

// @returns number of bytes written: all while the peer makes room
std::size_t LocalConnection::write(std::string_view bytes) {
  std::size_t sent = 0;
  while (sent < bytes.size() && !deaf_) {
    const ssize_t went =
        ::send(end_.number(), bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
    if (went >= 0) {
      sent += static_cast<std::size_t>(went);
    } else if (errno == EAGAIN || errno == EWOULDBLOCK) {
      pollfd room{end_.number(), POLLOUT, 0};
      if (poll(&room, 1, room_milliseconds) <= 0) break;
    } else if (errno != EINTR) {
      deaf_ = true;
    }
  }
  return sent;
}

void LocalConnection::flush() {
  if (!has_unsent()) return;
  unsent_.erase(0, write(unsent_));
  read();
}

void LocalConnection::read() {
  std::array<char, 65536> bytes;
  while (!closed_) {
    const ssize_t got = recv(end_.number(), bytes.data(), bytes.size(), 0);
    if (got > 0) {
      came_.append(bytes.data(), static_cast<std::size_t>(got));
      if (static_cast<std::size_t>(got) < bytes.size()) break;
    } else if (got == 0) {
      closed_ = true;
    } else if (errno == EAGAIN || errno == EWOULDBLOCK) {
      break;
    } else if (errno != EINTR) {
      closed_ = true;
    }
  }
  while (cut_message()) {
  }
}

// Close the connection because its message is not understood. @returns false
bool LocalConnection::refuse() {
  closed_ = true;
  came_.clear();
  return false;
}

// Take a message from the bytes read. @returns whether there was a whole one
bool LocalConnection::cut_message() {
  if (came_.size() < word) return false;
  const std::uint64_t count = number_at(came_, 0);
  if (count == 0 || count > max_frames_) return refuse();
  std::size_t place = (1 + count) * word;
  if (came_.size() < place) return false;
  std::size_t whole = place;
  for (std::uint64_t k = 0; k < count; ++k) {
    const std::uint64_t size = number_at(came_, (1 + k) * word);
    if (size > CodecLimits{}.max_frame_bytes) return refuse();
    whole += size;
  }
  if (came_.size() < whole) return false;
  RawMessage message;
  for (std::uint64_t k = 0; k < count; ++k) {
    const std::size_t size = number_at(came_, (1 + k) * word);
    message.push_back(came_.substr(place, size));
    place += size;
  }
  came_.erase(0, whole);
  messages_.push_back(std::move(message));
  return true;
}

std::optional<RawMessage> LocalConnection::take() {
  if (messages_.empty()) read();
  if (messages_.empty()) return std::nullopt;
  RawMessage message = std::move(messages_.front());
  messages_.pop_front();
  return message;
}

std::optional<LocalListener> LocalListener::listen(const std::string& endpoint,
                                                   std::size_t max_frames) {
  Descriptor door = socket_at(endpoint, ::bind);
  if (!door.is_open() || ::listen(door.number(), waiting_peers) != 0) return std::nullopt;
  return LocalListener(std::move(door), max_frames);
}

bool LocalListener::has(std::string_view route) const {
  const auto found = by_route_.find(route);
  return found != by_route_.end() && found->second.takes_messages();
}

bool LocalListener::send(const std::vector<std::string_view>& frames) {
  const auto found = by_route_.find(frames[0]);
  return found != by_route_.end() && found->second.send({frames.begin() + 1, frames.end()});
}

void LocalListener::flush() {
  for (auto& [route, connection] : by_route_) connection.flush();
}

bool LocalListener::has_unsent() const {
  return std::any_of(by_route_.begin(), by_route_.end(),
                     [](const auto& entry) { return entry.second.has_unsent(); });
}

void LocalListener::accept_all() {
  for (;;) {
    Descriptor came(accept4(door_.number(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (!came.is_open()) return;
    if (is_own_user(came.number())) nameless_.emplace_back(std::move(came), max_frames_);
  }
}

// Admit connections that have given their route. A route that is taken stays with the first one.
void LocalListener::welcome_new() {
  for (auto it = nameless_.begin(); it != nameless_.end();) {
    const auto route = it->take();
    if (route && route->size() == 1) by_route_.emplace((*route)[0], std::move(*it));
    if (route || it->is_closed()) {
      it = nameless_.erase(it);
    } else {
      ++it;
    }
  }
}

std::optional<RawMessage> LocalListener::take() {
  accept_all();
  if (!nameless_.empty()) welcome_new();
  // Connections are served in turn, beginning after the one that was served last.
  auto next = by_route_.upper_bound(last_served_);
  for (std::size_t looked = by_route_.size(); looked > 0; --looked) {
    if (next == by_route_.end()) next = by_route_.begin();
    auto message = next->second.take();
    if (message) {
      message->insert(message->begin(), next->first);
      last_served_ = next->first;
      return message;
    }
    next = next->second.is_closed() ? by_route_.erase(next) : std::next(next);
  }
  return std::nullopt;
}

std::map<int, bool> LocalListener::descriptors() const {
  std::map<int, bool> all = {{door_.number(), false}};
  for (const LocalConnection& connection : nameless_) all[connection.descriptor()] = false;
  for (const auto& [route, connection] : by_route_) {
    if (!connection.is_closed()) all[connection.descriptor()] = connection.has_unsent();
  }
  return all;
}

}  // namespace gabion
