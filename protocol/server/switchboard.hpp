// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "common/base/process.hpp"
#include "common/base/timer.hpp"
#include "protocol/channel/attention.hpp"
#include "protocol/channel/own_sleep.hpp"
#include "protocol/channel/peer_watch.hpp"
#include "protocol/channel/socket.hpp"
#include "protocol/channel/strangers.hpp"
#include "protocol/wire/deadlines.hpp"
#include "protocol/wire/handshake.hpp"
#include "protocol/wire/message.hpp"

namespace gabion {

/// The coupler's socket: sends requests to participants by name, waits for their replies, notices
/// those that die, freeze or speak nonsense, and sends signs of life of its own.
///
/// Any failure is final: it is told to all participants and every later call throws it again.
class Switchboard {
 public:
  Switchboard(const std::string& endpoint, const Deadlines& deadlines,
              const std::optional<ServerKeys>& keys = {});
  ~Switchboard();
  Switchboard(const Switchboard&) = delete;
  Switchboard& operator=(const Switchboard&) = delete;
  Switchboard(Switchboard&&) = delete;
  Switchboard& operator=(Switchboard&&) = delete;

  const std::string& endpoint() const { return endpoint_; }
  const Deadlines& deadlines() const { return deadlines_; }

  /// A hello that came, with the route to answer on; or the abort of one that cannot begin.
  struct Arrival {
    std::string route;
    Message hello;
  };
  /// Wait for one arrival at most about 0.1 s.
  /// @throws ProtocolError  a participant that is already here was lost
  std::optional<Arrival> next_arrival();
  /// Answer on a route that is no participant's, without waiting.
  void answer(const std::string& route, const Message& message);
  /// Tell a sender why it is not admitted, and drop its further messages.
  /// @param who  for the log
  void turn_down(const std::string& route, const std::string& who,
                 const std::vector<Mismatch>& mismatches);
  /// A participant that is welcome.
  struct Guest {
    std::string name;
    std::string route;
    std::string session;
    std::string label;  ///< name in messages to a person
    ProcessIdentity process;
    bool sends_heartbeat;
  };
  /// Answer the hello of an admitted participant. Signs of life go to it from then on, none before.
  void welcome(const Guest& guest, const Message& message);
  bool has_participant(const std::string& name) const { return peers_.contains(name); }

  /// Send a request; returns its sequence number.
  std::uint64_t send(const std::string& participant, Message request);
  /// The reply to that request. Messages that arrived count before a death: a reply that is there
  /// is returned, and a participant that has said "finished" may end.
  /// @throws ProtocolError  this or another participant died, froze, aborted or spoke nonsense; the
  ///                        answer deadline passed
  /// @throws Interrupted    a signal came, and no participant's death explains it
  Message wait_reply(const std::string& participant, std::uint64_t sequence);

  /// Let a signal end a wait only after interrupt::patience(), from now on: the caller looks at it
  /// between steps.
  void defer_signals() { signals_end_waits_ = false; }

  /// Log every few seconds, from now on, which participant is waited for, and what it was asked.
  void log_waits() { logs_waits_ = true; }

  /// Latch a failure, tell it to all participants.
  void abort(const std::string& reason);
  /// Tell those of these names that say hello so late why there is no run; for at most so long [s],
  /// or until a signal comes.
  void turn_away(const std::string& reason, std::vector<std::string> names, double seconds);
  /// Run `action`; when it throws, abort with the text of the exception.
  template <class Action>
  auto guarded(Action action);

  /// Set the phase of the coupler, which participants see in its signs of life.
  void set_phase(const std::string& phase);

 private:
  struct Question {
    std::uint64_t sequence;
    std::string what;  // text of describe()
    std::string kind;  // whom and of which type, for attention_
    Stopwatch since;   // time at which it was asked and the question before it answered
  };
  struct Peer {
    std::string route;
    std::string heartbeat_route;  // empty until the first heartbeat
    std::string session;
    bool sends_heartbeat = true;
    bool released = false;  // it has said "finished": its end is no failure any more
    std::unique_ptr<PeerWatch> watch;
    std::deque<Question> open;  // requests whose answers were not taken, oldest first
    std::deque<Message> inbox;  // answers that have come
    std::uint64_t last_sequence = 0;
  };

  bool listen(const Peer* awaited, Attention::Seconds look = {});
  bool pump(int milliseconds, Attention::Seconds look = {});
  void dispatch(const std::vector<std::string>& frames);
  void take(const std::string& participant, Message message);
  void release(const std::string& participant);
  void heartbeat_came(const std::string& route, const Message& message);
  bool is_somebody_silent() const;
  bool signal_ends_wait();
  void check_deaths(const Peer* awaited);
  void hear_out(const Peer& gone);
  void refuse_late_arrivals();
  std::optional<Message> take_reply(const std::string& participant, std::uint64_t sequence);
  bool post(const std::string& route, const Message& message, bool waits = true);
  Message new_beat();
  void beat_when_due();
  void beat_in_background();
  Peer& peer(const std::string& name);
  void require_usable() const;

  Deadlines deadlines_;
  std::shared_ptr<SocketContext> context_;
  std::string endpoint_;
  std::map<std::string, Peer> peers_;
  std::vector<Arrival> arrivals_;
  Strangers strangers_;
  std::string failure_;
  Attention attention_;
  bool signals_end_waits_ = true;
  bool logs_waits_ = false;
  std::optional<Stopwatch> since_signal_;
  Stopwatch since_health_check_;
  OwnSleep own_sleep_;
  int silent_looks_ = 0;  // in a row in which somebody was silent

  std::mutex socket_mutex_;  // guards socket_, heartbeat routes and the members below
  Socket socket_;
  Stopwatch since_beat_;
  std::uint64_t num_beats_ = 0;
  std::string phase_ = "handshake";
  Stopwatch in_phase_;

  std::mutex stop_mutex_;
  std::condition_variable stop_;
  bool stopping_ = false;
  std::thread background_;
};

template <class Action>
auto Switchboard::guarded(Action action) {
  require_usable();
  try {
    return action();
  } catch (const ProtocolError& problem) {
    const double slept = own_sleep_.recent();
    if (!failure_.empty() || slept < deadlines_.silence / 2) {
      abort(problem.what());
      throw;
    }
    const std::string reason = after_own_sleep(slept, problem.what());
    abort(reason);
    throw ProtocolError(reason);
  } catch (const Error& problem) {
    abort(problem.what());
    throw;
  }
}

}  // namespace gabion
