// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/channel/heartbeat.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <span>

#include "common/base/interrupt.hpp"
#include "common/base/printable.hpp"
#include "protocol/channel/own_sleep.hpp"
#include "protocol/wire/codec.hpp"

namespace gabion {
namespace {

constexpr double poll_period = 0.1;   // [s]
constexpr double grace = 1.0;         // [s] for a computation to end by itself
constexpr double output_grace = 30.;  // [s] for files to be completed

}  // namespace

Heartbeat::Heartbeat(std::shared_ptr<SocketContext> context, const HeartbeatSettings& settings)
    : settings_(settings),
      socket_(Socket::connect_dealer(std::move(context), settings.endpoint, settings.route, 0,
                                     settings.keys)) {
  thread_ = interrupt::quiet_thread([this] { run(); });
}

Heartbeat::~Heartbeat() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void Heartbeat::set_phase(const std::string& phase, bool busy) {
  const std::lock_guard lock(mutex_);
  phase_ = phase;
  busy_ = busy;
  in_phase_ = Stopwatch();
}

void Heartbeat::watch(std::shared_ptr<PeerWatch> coupler, double interval,
                      double silence_deadline) {
  const std::lock_guard lock(mutex_);
  coupler_ = std::move(coupler);
  interval_ = interval;
  silence_deadline_ = silence_deadline;
}

void Heartbeat::run() {
  Stopwatch since_beat;
  Stopwatch since_look;
  send_alive();
  std::unique_lock lock(mutex_);
  while (!changed_.wait_for(lock, std::chrono::duration<double>(std::min(poll_period, interval_)),
                            [this] { return stopping_; })) {
    const bool due = since_beat.seconds() >= interval_;
    lock.unlock();
    receive_alive();
    if (due) {
      since_beat = Stopwatch();
      send_alive();
    }
    check_coupler(since_look.seconds());
    since_look = Stopwatch();
    lock.lock();
  }
}

void Heartbeat::send_alive() {
  Message alive{.type = "alive",
                .sequence = ++num_beats_,
                .fields = {{"participant", settings_.participant}, {"session", settings_.session}},
                .arrays = {}};
  {
    const std::lock_guard lock(mutex_);
    alive.fields["phase"] = phase_;
    alive.fields["seconds"] = in_phase_.seconds();
  }
  const EncodedMessage encoded = encode(alive);
  try {
    socket_.send({encoded.header});
  } catch (const std::exception&) {
    // The coupler notices the silence; the connection's own socket reports what is wrong.
  }
}

void Heartbeat::receive_alive() {
  try {
    while (const auto frames = socket_.receive(0)) {
      const Message message = decode(std::span(*frames));
      if (message.type != "alive") continue;
      const std::lock_guard lock(mutex_);
      if (coupler_) coupler_->sign_of_life(message.text("phase"));
    }
  } catch (const std::exception&) {
    // A message that is not understood is no sign of life.
  }
}

/// While the solver computes, nobody waits for the coupler. If it is lost then, the solver gets a
/// moment to end by itself; after that the process ends, so that no orphan computes for hours.
void Heartbeat::check_coupler(double slept) {
  std::shared_ptr<PeerWatch> coupler;
  std::string phase;
  bool busy = false;
  double silence_deadline = 0;
  {
    const std::lock_guard lock(mutex_);
    coupler = coupler_;
    phase = phase_;
    busy = busy_;
    silence_deadline = silence_deadline_;
  }
  if (!coupler || !settings_.exit_when_coupler_is_lost) return;
  if (slept > longest_slice) coupler->forgive();
  auto loss = coupler->death();
  if (!loss) loss = coupler->silence(silence_deadline);
  if (!loss || !busy) {
    lost_ = false;
    return;
  }
  if (!lost_) since_loss_ = Stopwatch();
  lost_ = true;
  const bool writing =
      phase == "write_output" || phase == "save" || phase.starts_with("accept_step");
  if (since_loss_.seconds() < (writing ? output_grace : grace)) return;
  std::fputs(fmt::format("[{}] error: {}; this process ends in phase \"{}\"\n",
                         settings_.participant, printable(*loss), printable(phase))
                 .c_str(),
             stderr);
  std::_Exit(ProtocolError("").exit_code());
}

}  // namespace gabion
