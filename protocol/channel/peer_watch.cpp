// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/channel/peer_watch.hpp"

#include <fmt/format.h>

#include "protocol/wire/deadlines.hpp"

namespace gabion {

PeerWatch::PeerWatch(std::string label, ProcessIdentity process)
    : label_(std::move(label)),
      process_(std::move(process)),
      last_sign_(Clock::now()),
      silent_from_(last_sign_) {}

double PeerWatch::seconds_since(Clock::time_point when) const {
  return std::chrono::duration<double>(Clock::now() - when).count();
}

void PeerWatch::sign_of_life() {
  const std::lock_guard lock(mutex_);
  last_sign_ = silent_from_ = Clock::now();
}

void PeerWatch::sign_of_life(const std::string& phase) {
  const std::lock_guard lock(mutex_);
  last_sign_ = silent_from_ = Clock::now();
  phase_ = phase;
}

void PeerWatch::asked(const std::string& what) {
  const std::lock_guard lock(mutex_);
  asked_ = what;
  phase_ = "waiting";
}

std::string PeerWatch::question() const {
  const std::lock_guard lock(mutex_);
  return asked_;
}

void PeerWatch::forgive() {
  const std::lock_guard lock(mutex_);
  silent_from_ = Clock::now();
}

std::optional<std::string> PeerWatch::death() const {
  if (look_up(process_) != ProcessState::gone) return std::nullopt;
  return fmt::format("{} has died: no process; {}", label_, last_words());
}

std::optional<std::string> PeerWatch::silence(double deadline) const {
  double silent = 0;
  {
    const std::lock_guard lock(mutex_);
    silent = seconds_since(silent_from_);
  }
  if (silent <= deadline) return std::nullopt;
  const ProcessState state = look_up(process_);
  const char* found = state == ProcessState::stopped   ? "its process is stopped"
                      : state == ProcessState::running ? "its process exists but sends nothing"
                                                       : "its process cannot be seen from here";
  return fmt::format("{} is silent for {:.1f} s (limit {} s, {}): {}; {}", label_, silent, deadline,
                     deadline_option("silence_deadline"), found, last_words());
}

std::string PeerWatch::last_words() const {
  const std::lock_guard lock(mutex_);
  // A heartbeat sent just before the request arrived still names the phase before.
  const bool idle = phase_ == "waiting" || phase_ == "handshake";
  const std::string& phase = idle && !asked_.empty() ? asked_ : phase_;
  return fmt::format("last sign of life {:.1f} s ago in phase \"{}\"", seconds_since(last_sign_),
                     phase);
}

}  // namespace gabion
