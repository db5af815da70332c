// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace gabion {

class ConfigReader;
struct Key;

/// Longest duration of each wait [s]. The coupler's values hold for all; a participant has its own
/// `connect` and gets the others in the welcome.
struct Deadlines {
  double connect = 300;    ///< until every participant has connected
  double silence = 10;     ///< without any sign of life: the peer is dead, frozen or unreachable
  double answer = 3600;    ///< alive, but the answer to one request does not come
  double idle = 14400;     ///< the coupler is alive, but asks a participant nothing
  double heartbeat = 0.5;  ///< between two signs of life
};

/// Read the deadlines from the object "protocol" of coupler.json: keys "connect_deadline",
/// "silence_deadline", "answer_deadline", "idle_deadline", "heartbeat". Does not call finish().
Deadlines read_deadlines(ConfigReader& in);
std::vector<Key> deadline_keys();

/// "protocol/silence_deadline in coupler.json": where to change it, for error messages.
std::string deadline_option(const std::string& name);

}  // namespace gabion
