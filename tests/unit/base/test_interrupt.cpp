// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <csignal>
#include <utility>

#include "common/base/interrupt.hpp"

namespace gabion::test_interrupt {
namespace {

/// Handlers for both signals until the end of the test.
class Installed {
 public:
  Installed() { interrupt::install(); }
  ~Installed() {
    interrupt::clear();
    std::signal(SIGINT, SIG_DFL);
    std::signal(SIGTERM, SIG_DFL);
  }
  Installed(const Installed&) = delete;
  Installed& operator=(const Installed&) = delete;
  Installed(Installed&&) = delete;
  Installed& operator=(Installed&&) = delete;
};

TEST(Interrupt, first_signal_is_the_reason) {
  for (const auto& [first, second] : {std::pair{SIGINT, SIGTERM}, std::pair{SIGTERM, SIGINT}}) {
    const Installed handlers;
    std::raise(first);
    std::raise(second);
    EXPECT_EQ(interrupt::requested(), first);
  }
}

/// A process that had no time in between: the system takes them by their numbers.
TEST(Interrupt, of_two_that_wait_the_terminals_counts) {
  const Installed handlers;
  sigset_t both;
  sigset_t before;
  sigemptyset(&both);
  sigaddset(&both, SIGINT);
  sigaddset(&both, SIGTERM);
  sigprocmask(SIG_BLOCK, &both, &before);
  std::raise(SIGTERM);
  std::raise(SIGINT);
  sigprocmask(SIG_SETMASK, &before, nullptr);
  EXPECT_EQ(interrupt::requested(), SIGINT);
}

}  // namespace
}  // namespace gabion::test_interrupt
