// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/deadlines.hpp"

#include <fmt/format.h>

namespace gabion {

Deadlines read_deadlines(ConfigReader& in) {
  const Deadlines defaults;
  Deadlines read;
  read.connect = in.number_or("connect_deadline", defaults.connect, positive());
  read.silence = in.number_or("silence_deadline", defaults.silence, positive());
  read.answer = in.number_or("answer_deadline", defaults.answer, positive());
  read.idle = in.number_or("idle_deadline", defaults.idle, positive());
  read.heartbeat = in.number_or("heartbeat", defaults.heartbeat, positive());
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
