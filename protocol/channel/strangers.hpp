// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <set>
#include <string>

#include "common/base/timer.hpp"

namespace gabion {

/// Senders that are no participants. Each is refused once; its further messages are dropped unread.
/// The log names the first senders and counts the others, so that nobody can fill it.
class Strangers {
 public:
  ~Strangers();

  /// Whether a message on this route is to be dropped, since its sender was refused. Counts the
  /// message.
  bool drops(const std::string& route);
  /// Refuse this sender, or merely ignore it. @param what  a sentence for the log
  void refuse(const std::string& route, const std::string& what);

 private:
  void say_count();

  std::set<std::string> routes_;
  std::deque<std::string> oldest_;  // entries of routes_, in the order in which they came
  std::int64_t count_ = 0;          // number of their messages
  std::int64_t said_ = 0;           // messages that the log has named
  int named_ = 0;
  Stopwatch since_said_;
};

}  // namespace gabion
