// SPDX-License-Identifier: BSD-3-Clause
#include "common/base/interrupt.hpp"

#include <atomic>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <utility>

namespace gabion {
namespace {

std::atomic<int> came = 0;
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler writes it");

/// The first one is the reason: a launcher sends SIGTERM after whatever made it end.
extern "C" void note_signal(int signal) {
  int none = 0;
  came.compare_exchange_strong(none, signal);
}

}  // namespace

Interrupted::Interrupted(int signal)
    : Error(std::string("interrupted by signal ") + std::to_string(signal) + " (" +
            strsignal(signal) + ")"),
      signal_(signal) {}

namespace interrupt {

void install() {
  struct sigaction action = {};
  action.sa_handler = note_signal;
  sigemptyset(&action.sa_mask);
  sigaddset(&action.sa_mask, SIGINT);  // of two that wait, the one that is handled first counts
  sigaddset(&action.sa_mask, SIGTERM);
  action.sa_flags = SA_RESETHAND;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

int requested() {
  return came.load();
}

double patience() {
  constexpr double last_words = 0.2;
  const char* text = std::getenv("OMPI_MCA_odls_base_sigkill_timeout");
  const double timeout = text == nullptr ? 1 : std::strtod(text, nullptr);
  return timeout - last_words;
}

void check() {
  if (const int signal = requested(); signal != 0) throw Interrupted(signal);
}

std::thread quiet_thread(std::function<void()> work) {
  sigset_t all;
  sigset_t before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);  // a new thread inherits the mask
  std::thread thread(std::move(work));
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  return thread;
}

void clear() {
  came.store(0);
}

}  // namespace interrupt
}  // namespace gabion
