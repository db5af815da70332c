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
      seconds("connect_deadline", defaults.connect,
              "Time within which every participant has to connect."),
      seconds(
          "silence_deadline", defaults.silence,
          "Time without a sign of life after which another program counts as dead; at least twice "
          "`heartbeat`. Holds for the participants too."),
      seconds("answer_deadline", defaults.answer,
              "Longest time that a participant that is alive may take to answer one request."),
      seconds("idle_deadline", defaults.idle,
              "Longest time that a participant waits for a request of a coupler that is alive."),
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
