// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/server/switchboard.hpp"

#include <algorithm>
#include <utility>

#include "common/base/interrupt.hpp"
#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "protocol/wire/codec.hpp"
#include "protocol/wire/exchange.hpp"

namespace gabion {
namespace {

constexpr int patient_looks = 4;  // polls in which others were heard, until one counts as silent
constexpr double last_words_wait = 0.5;  // [s] until the connection of a process that ended closes
constexpr double closing_wait = 1.0;     // [s] until a process ends that closed its connection
constexpr double wait_log_period = 3;    // [s]
constexpr int most_messages_a_pass = 256;
constexpr double longest_pass = 0.1;  // [s]

}  // namespace

Switchboard::Switchboard(const std::string& endpoint, const Deadlines& deadlines,
                         const std::optional<ServerKeys>& keys)
    : deadlines_(deadlines),
      context_(make_socket_context()),
      socket_(Socket::bind_router(context_, endpoint, keys)) {
  endpoint_ = socket_.endpoint();
  background_ = interrupt::quiet_thread([this] { beat_in_background(); });
}

Switchboard::~Switchboard() {
  {
    const std::lock_guard lock(stop_mutex_);
    stopping_ = true;
  }
  stop_.notify_all();
  background_.join();
  if (!failure_.empty()) return;
  try {
    abort("the coupler ended without finishing the run");
  } catch (const std::exception&) {
    // The participants cannot be told; they notice the silence.
  }
}

void Switchboard::require_usable() const {
  require<ProtocolError>(failure_.empty(), "the coupling has failed before: " + failure_);
}

Switchboard::Peer& Switchboard::peer(const std::string& name) {
  const auto found = peers_.find(name);
  require<ProtocolError>(found != peers_.end(), "no participant \"{}\"", name);
  return found->second;
}

/// The caller holds socket_mutex_.
bool Switchboard::post(const std::string& route, const Message& message, bool waits) {
  const EncodedMessage encoded = encode(message);
  std::vector<std::string_view> frames = {route, encoded.header};
  frames.insert(frames.end(), encoded.payloads.begin(), encoded.payloads.end());
  return waits ? socket_.send(frames) : socket_.try_send(frames);
}

void Switchboard::answer(const std::string& route, const Message& message) {
  const std::lock_guard lock(socket_mutex_);
  if (!post(route, message, false)) log::debug("\"{}\" found no reader", message.type);
}

void Switchboard::turn_down(const std::string& route, const std::string& who,
                            const std::vector<Mismatch>& mismatches) {
  strangers_.refuse(route, fmt::format("{} was refused: {}", who, mismatch_text(mismatches)));
  answer(route, refusal(mismatches));
}

void Switchboard::welcome(const Guest& guest, const Message& message) {
  const std::lock_guard lock(socket_mutex_);
  if (!post(guest.route, message, false)) log::warn("{} is gone already", guest.label);
  Peer& added = peers_[guest.name];
  added.route = guest.route;
  added.session = guest.session;
  added.sends_heartbeat = guest.sends_heartbeat;
  added.watch = std::make_unique<PeerWatch>(guest.label, guest.process);
}

std::optional<Switchboard::Arrival> Switchboard::next_arrival() {
  require_usable();
  if (arrivals_.empty()) listen(nullptr);
  if (arrivals_.empty()) return std::nullopt;
  std::optional<Arrival> first(std::move(arrivals_.front()));
  arrivals_.erase(arrivals_.begin());
  return first;
}

std::uint64_t Switchboard::send(const std::string& participant, Message request) {
  return guarded([&] {
    if (signal_ends_wait()) {
      check_deaths(nullptr);
      interrupt::check();
    }
    Peer& to = peer(participant);
    request.sequence = ++to.last_sequence;
    to.open.push_back({request.sequence, describe(request), participant + " " + request.type, {}});
    if (to.open.size() == 1) to.watch->asked(to.open.front().what);
    bool sent = false;
    {
      const std::lock_guard lock(socket_mutex_);
      sent = post(to.route, request);
    }
    if (!sent) {
      // A dying process closes its connection a moment before it is gone.
      const Stopwatch waited;
      while (!to.watch->death() && waited.seconds() < closing_wait) pump(20);
      check_deaths(nullptr);
      throw ProtocolError(fmt::format("{} cannot be reached: its connection is closed; {}",
                                      to.watch->label(), to.watch->last_words()));
    }
    return request.sequence;
  });
}

Message Switchboard::wait_reply(const std::string& participant, std::uint64_t sequence) {
  return guarded([&] {
    const Peer& awaited = peer(participant);
    require<ProtocolError>(!awaited.open.empty(), "{} was not asked", awaited.watch->label());
    const Question asked = awaited.open.front();
    const Stopwatch waited;
    Attention::Seconds look = attention_.before(asked.kind);
    Stopwatch since_log;
    for (;;) {
      if (auto reply = take_reply(participant, sequence)) {
        attention_.note(asked.kind, Attention::Seconds(waited.seconds()));
        return std::move(*reply);
      }
      const bool late = asked.since.seconds() > deadlines_.answer;  // judged before the poll
      listen(&awaited, std::exchange(look, {}));
      refuse_late_arrivals();
      if (!awaited.inbox.empty()) continue;
      const PeerWatch& watch = *awaited.watch;
      if (logs_waits_ && since_log.seconds() > wait_log_period) {
        since_log = Stopwatch();
        log::info("waiting for {}, {}, since {:.0f} s", watch.label(), watch.question(),
                  asked.since.seconds());
      }
      require<ProtocolError>(!late, [&] {
        return fmt::format("{} is alive but has not answered for {:.1f} s (limit {} s, {}); {}",
                           watch.label(), asked.since.seconds(), deadlines_.answer,
                           deadline_option("answer_deadline"), watch.last_words());
      });
    }
  });
}

std::optional<Message> Switchboard::take_reply(const std::string& participant,
                                               std::uint64_t sequence) {
  Peer& from = peer(participant);
  if (from.inbox.empty()) return std::nullopt;
  Message reply = std::move(from.inbox.front());
  from.inbox.pop_front();
  require<ProtocolError>(reply.sequence == sequence, [&] {
    return fmt::format("{} answered \"{}\" to request {}, expected an answer to {}; {}",
                       from.watch->label(), reply.type, reply.sequence, sequence,
                       from.watch->last_words());
  });
  from.open.pop_front();
  if (!from.open.empty()) from.open.front().since = Stopwatch();
  from.watch->asked(from.open.empty() ? "" : from.open.front().what);
  return reply;
}

void Switchboard::release(const std::string& participant) {
  const std::lock_guard lock(socket_mutex_);
  peer(participant).released = true;
}

void Switchboard::abort(const std::string& reason) {
  if (!failure_.empty()) return;
  failure_ = reason;
  const Message message = new_message("abort", {{"reason", reason}});
  const std::lock_guard lock(socket_mutex_);
  for (auto& [name, to] : peers_) {
    if (!to.released) post(to.route, message);
  }
}

void Switchboard::turn_away(const std::string& reason, std::vector<std::string> names,
                            double seconds) {
  const Message message = new_message("abort", {{"reason", reason}});
  const Stopwatch waited;
  for (;;) {
    for (const Arrival& late : arrivals_) {
      std::erase(names, text_or_empty(late.hello, "participant"));
      if (late.hello.type == "hello") answer(late.route, message);
    }
    arrivals_.clear();
    if (names.empty() || waited.seconds() > seconds || interrupt::requested() != 0) return;
    try {
      pump(slice_milliseconds);
    } catch (const ProtocolError& problem) {
      log::debug("after the failure: {}", problem.what());
    }
  }
}

void Switchboard::set_phase(const std::string& phase) {
  const std::lock_guard lock(socket_mutex_);
  phase_ = phase;
  in_phase_ = Stopwatch();
}

/// Take the messages that have come, waiting for the first one at most so long. Returns whether any
/// came. A sender without end does not hold up the caller's other checks.
bool Switchboard::pump(int milliseconds, Attention::Seconds look) {
  std::optional<Stopwatch> since_first;
  for (int taken = 0; taken < most_messages_a_pass; ++taken) {
    std::optional<std::vector<std::string>> frames;
    {
      const std::lock_guard lock(socket_mutex_);
      frames = socket_.receive(since_first ? 0 : milliseconds, look);
      beat_when_due();
    }
    if (!frames) return since_first.has_value();
    if (!since_first) since_first.emplace();
    dispatch(*frames);
    if (since_first->seconds() > longest_pass) break;
  }
  return true;
}

void Switchboard::dispatch(const std::vector<std::string>& frames) {
  const std::string& route = frames[0];
  const auto from = std::find_if(peers_.begin(), peers_.end(), [&route](const auto& entry) {
    return entry.second.route == route;
  });
  const bool known = from != peers_.end();
  if (!known && strangers_.drops(route)) return;
  Message message;
  try {
    message = decode(std::span(frames).subspan(1));
    if (message.type == "alive") return heartbeat_came(route, message);
    if (message.type == "abort" && known && !from->second.released) message.text("reason");
  } catch (const ProtocolError& problem) {
    if (known) {
      const PeerWatch& watch = *from->second.watch;
      throw ProtocolError(fmt::format("{} sent a message that is not understood: {}; {}",
                                      watch.label(), problem.what(), watch.last_words()));
    }
    return turn_down(route, "a message that is not the protocol",
                     {{"first message", "a hello that is understood", problem.what()}});
  }
  if (known) return take(from->first, std::move(message));
  if (message.type == "hello" || message.type == "abort") {
    arrivals_.push_back({route, std::move(message)});
  } else {
    strangers_.refuse(route,
                      "ignored a sender that has not said hello, but " + shortened(message.type));
  }
}

/// Take a message of a participant's main socket.
void Switchboard::take(const std::string& participant, Message message) {
  Peer& from = peer(participant);
  if (from.released) return;
  const PeerWatch& watch = *from.watch;
  require<ProtocolError>(message.type != "abort", [&] {
    return fmt::format("{} ended the run: {}", watch.label(), message.text("reason"));
  });
  require<ProtocolError>(from.inbox.size() < from.open.size(), [&] {
    return fmt::format("{} sent {} without being asked; {}", watch.label(), shortened(message.type),
                       watch.last_words());
  });
  from.watch->sign_of_life();
  if (message.type == "finished") release(participant);
  from.inbox.push_back(std::move(message));
}

void Switchboard::heartbeat_came(const std::string& route, const Message& message) {
  const auto found = peers_.find(message.text("participant"));
  if (found == peers_.end() || found->second.session != message.text("session")) return;
  found->second.watch->sign_of_life(message.text("phase"));
  const std::lock_guard lock(socket_mutex_);
  found->second.heartbeat_route = route;
}

void Switchboard::refuse_late_arrivals() {
  for (const Arrival& late : std::exchange(arrivals_, {})) {
    if (late.hello.type != "hello") continue;
    turn_down(late.route, "a participant that came late",
              {{"state of the run", "running, all participants are here", "hello"}});
  }
}

/// Wait a slice for messages, then check all participants. Silence is judged before the queue is
/// read, deaths and signals after it; none of them matters once the awaited participant has
/// answered. @returns whether anything came
bool Switchboard::listen(const Peer* awaited, Attention::Seconds look) {
  const auto has_answered = [awaited] { return awaited && !awaited->inbox.empty(); };
  const bool was_silent = is_somebody_silent();
  const bool came = pump(slice_milliseconds, look);
  const bool ends = signal_ends_wait();
  const double elapsed = since_health_check_.seconds();
  if (has_answered() || (elapsed < health_check_period && !ends)) return came;
  since_health_check_ = Stopwatch();
  if (elapsed > longest_slice) {
    for (auto& [name, checked] : peers_) checked.watch->forgive();
  }
  check_deaths(awaited);
  if (has_answered()) return true;
  if (ends) interrupt::check();
  // A sign of life may be close behind one of another participant.
  silent_looks_ = was_silent ? silent_looks_ + 1 : 0;
  if (!was_silent || (came && silent_looks_ < patient_looks)) return came;
  for (const auto& [name, checked] : peers_) {
    if (checked.released || !checked.sends_heartbeat) continue;
    if (const auto silence = checked.watch->silence(deadlines_.silence)) {
      throw ProtocolError(*silence);
    }
  }
  return came;
}

bool Switchboard::is_somebody_silent() const {
  return std::any_of(peers_.begin(), peers_.end(), [this](const auto& entry) {
    const Peer& checked = entry.second;
    return !checked.released && checked.sends_heartbeat &&
           checked.watch->silence(deadlines_.silence);
  });
}

bool Switchboard::signal_ends_wait() {
  if (interrupt::requested() != 0 && !since_signal_) since_signal_.emplace();
  return since_signal_ && (signals_end_waits_ || since_signal_->seconds() > interrupt::patience());
}

/// Check for deaths. Messages that arrived count before a death: last words are taken first.
void Switchboard::check_deaths(const Peer* awaited) {
  for (const auto& [name, checked] : peers_) {
    if (checked.released) continue;
    const auto death = checked.watch->death();
    if (!death) continue;
    hear_out(checked);
    if (checked.released) continue;
    if (awaited && !awaited->inbox.empty()) return;  // the next request to it finds the death
    throw ProtocolError(*death);
  }
}

/// Take all that a process said before it ended, until its connection is closed. Its abort, if
/// there is one, is the better message.
void Switchboard::hear_out(const Peer& gone) {
  const Stopwatch waited;
  bool connected = true;
  while (connected && !gone.released && waited.seconds() < last_words_wait) {
    pump(20);
    const std::lock_guard lock(socket_mutex_);
    connected = post(gone.route, new_beat());
  }
  pump(0);
}

/// The caller holds socket_mutex_.
Message Switchboard::new_beat() {
  return {.type = "alive",
          .sequence = ++num_beats_,
          .fields = {{"phase", phase_}, {"seconds", in_phase_.seconds()}},
          .arrays = {}};
}

void Switchboard::beat_when_due() {
  if (since_beat_.seconds() < deadlines_.heartbeat) return;
  since_beat_ = Stopwatch();
  const Message alive = new_beat();
  for (auto& [name, to] : peers_) {
    if (to.released || !to.sends_heartbeat) continue;
    post(to.heartbeat_route.empty() ? to.route : to.heartbeat_route, alive, false);
  }
}

/// Send signs of life while the coupler's own thread computes; a thread that waits sends its own.
void Switchboard::beat_in_background() {
  std::unique_lock stop_lock(stop_mutex_);
  const auto period = std::chrono::duration<double>(deadlines_.heartbeat / 4);
  while (!stop_.wait_for(stop_lock, period, [this] { return stopping_; })) {
    own_sleep_.tick();
    const std::unique_lock lock(socket_mutex_, std::try_to_lock);
    if (!lock.owns_lock()) continue;
    try {
      beat_when_due();
    } catch (const std::exception&) {
      // The coupler's own thread finds this failure, too, and can report it to a caller.
    }
  }
}

}  // namespace gabion
