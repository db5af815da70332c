// SPDX-License-Identifier: BSD-3-Clause
// A structure from elsewhere that speaks another version of the protocol:
//     fake_participant ENDPOINT VERSION
// Prints the coupler's answer; exit code 0 when it was refused.
#include <fmt/format.h>

#include <cstdio>
#include <span>
#include <string>
#include <vector>

#include "protocol/codec.hpp"
#include "protocol/handshake.hpp"
#include "protocol/socket.hpp"

int main(int argc, char** argv) {
  using namespace gabion;
  if (argc != 3) return 2;
  Hello hello;
  hello.protocol = argv[2];
  hello.participant = "structure";
  hello.program = "fake_participant";
  hello.program_version = "0";
  hello.session = "fake";
  hello.dimension = 2;
  hello.receives = force();
  hello.sends = displacement();
  hello.interfaces = {{"wall", 2, {0.25, 0, 0.25, 0.05}, 2, {0, 1}}};
  hello.sends_heartbeat = false;

  Socket socket = Socket::connect_dealer(make_socket_context(), argv[1], "structure#fake");
  const Message message = to_message(hello);
  const EncodedMessage encoded = encode(message);
  std::vector<std::string_view> frames = {encoded.header};
  frames.insert(frames.end(), encoded.payloads.begin(), encoded.payloads.end());
  socket.send(frames);
  for (int i = 0; i < 200; ++i) {
    const auto answer = socket.receive(100);
    if (!answer) continue;
    const Message decoded = decode(std::span(*answer));
    if (decoded.type == "alive") continue;
    std::puts(fmt::format("{} {}", decoded.type, decoded.fields.dump()).c_str());
    return decoded.type == "refused" ? 0 : 1;
  }
  std::puts("no answer");
  return 1;
}
