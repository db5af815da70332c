// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/wire/deadlines.hpp"

#include <fmt/format.h>

#include "common/settings/config_reader.hpp"

namespace gabion {

std::vector<Key> deadline_keys() {
  const Deadlines defaults;
  const auto seconds = [](const std::string& name, double fallback, const std::string& sentence) {
    return key::number(name, "s", sentence).in(positive()).or_else(fallback);
  };
  return {
      seconds("connect_deadline", defaults.connect, "Until every participant has connected."),
      seconds(
          "silence_deadline", defaults.silence,
          "Without any sign of life the other side is dead, frozen or unreachable; at least twice "
          "`heartbeat`. Holds for the participants too."),
      seconds("answer_deadline", defaults.answer,
              "A participant is alive, but one request is not answered."),
      seconds("idle_deadline", defaults.idle,
              "A participant waits so long for a request of a coupler that is alive."),
      seconds("heartbeat", defaults.heartbeat, "Time between two signs of life.")};
}

Deadlines read_deadlines(ConfigReader& in) {
  Deadlines read;
  read.connect = in.number("connect_deadline");
  read.silence = in.number("silence_deadline");
  read.answer = in.number("answer_deadline");
  read.idle = in.number("idle_deadline");
  read.heartbeat = in.number("heartbeat");
  if (read.silence < 2 * read.heartbeat) {
    in.fail("silence_deadline",
            fmt::format("found {} s; allowed: at least twice the heartbeat of {} s", read.silence,
                        read.heartbeat));
  }
  return read;
}

std::string deadline_option(const std::string& name) {
  return "option protocol/" + name + " in coupler.json";
}

}  // namespace gabion
