// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <map>
#include <string>

namespace gabion {

/// Decides whether to poll for a message or to sleep until it comes. A thread that sleeps takes 50
/// to 100 us to wake, one that polls takes a processor from other work. So short waits poll, long
/// ones sleep; waits of one kind (which request, to whom) are expected to be about as long as those
/// before.
class Attention {
 public:
  using Seconds = std::chrono::duration<double>;

  /// Time to poll before sleep.
  Seconds before(const std::string& kind) const {
    const auto known = means_.find(kind);
    return known == means_.end() || known->second <= short_wait ? longest_look : Seconds(0);
  }
  /// Note the length of a wait of this kind.
  void note(const std::string& kind, Seconds wait) {
    const auto [known, is_new] = means_.emplace(kind, wait);
    if (!is_new) known->second += share_of_last * (wait - known->second);
  }

 private:
  static constexpr Seconds short_wait{1e-3};
  static constexpr Seconds longest_look{2e-3};
  static constexpr double share_of_last = 0.25;
  std::map<std::string, Seconds> means_;
};

}  // namespace gabion
