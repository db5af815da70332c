// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <set>
#include <string>

#include "common/base/timer.hpp"

namespace gabion {

/// Senders that are no participants. Each is refused once, then dropped unread. The log names the
/// first of them and counts the rest, so that nobody can fill it.
class Strangers {
 public:
  ~Strangers();

  /// Whether what came on this route is to be dropped, since its sender was refused. Counts it.
  bool drops(const std::string& route);
  /// This sender is refused, or only not heard. @param what  a sentence for the log
  void refuse(const std::string& route, const std::string& what);

 private:
  void say_count();

  std::set<std::string> routes_;
  std::deque<std::string> oldest_;  // of routes_, in the order in which they came
  std::int64_t count_ = 0;          // of messages
  std::int64_t said_ = 0;           // of them in the log
  int named_ = 0;
  Stopwatch since_said_;
};

}  // namespace gabion
