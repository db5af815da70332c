// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <vector>

#include "protocol/channel/socket.hpp"
#include "protocol/wire/codec.hpp"
#include "protocol/wire/handshake.hpp"

namespace gabion::test {

/// A participant that says whatever the test wants, right or wrong, frame by frame.
class RawParticipant {
 public:
  RawParticipant(const std::string& endpoint, const std::string& route)
      : socket_(Socket::connect_dealer(make_socket_context(), endpoint, route)) {}

  void send(const Message& message) {
    const EncodedMessage encoded = encode(message);
    std::vector<std::string_view> frames = {encoded.header};
    frames.insert(frames.end(), encoded.payloads.begin(), encoded.payloads.end());
    send_frames(frames);
  }
  void send_frames(const std::vector<std::string_view>& frames) { socket_.send(frames); }

  /// The next message; type "" after so many milliseconds without one.
  Message receive_any(int milliseconds = 50000) {
    const auto frames = socket_.receive(milliseconds);
    return frames ? decode(std::span(*frames)) : Message{};
  }
  /// The next message that is no sign of life.
  Message receive(int milliseconds = 50000) {
    Message message;
    do {
      message = receive_any(milliseconds);
    } while (message.type == "alive");
    return message;
  }

 private:
  Socket socket_;
};

/// A hello that fits expected(name) with one interface "wall" of three vertices.
inline Hello good_hello(const std::string& name) {
  Hello hello;
  hello.participant = name;
  hello.program = "foreign";
  hello.program_version = "7";
  hello.session = name + "-session";
  hello.scene_hash = "abc";
  hello.dimension = 2;
  hello.receives = name == "soil" ? displacement() : force();
  hello.sends = name == "soil" ? force() : displacement();
  InterfaceMesh mesh;
  mesh.name = "wall";
  mesh.dim = 2;
  mesh.coordinates = {0, 0, 0, 1, 0, 2};
  mesh.vertices_per_facet = 2;
  mesh.facets = {0, 1, 1, 2};
  hello.interfaces = {mesh};
  hello.sends_heartbeat = false;
  return hello;
}

}  // namespace gabion::test
