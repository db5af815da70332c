// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <exception>
#include <memory>
#include <optional>
#include <string>

#include "common/run/solver.hpp"
#include "protocol/channel/attention.hpp"
#include "protocol/channel/heartbeat.hpp"
#include "protocol/channel/peer_watch.hpp"
#include "protocol/channel/socket.hpp"
#include "protocol/participant/request_source.hpp"
#include "protocol/wire/handshake.hpp"
#include "protocol/wire/message.hpp"

namespace gabion {

/// The coupler refused this participant, or ended the run before its first step. The coupler logs
/// the reason, too.
class NeverBegun : public ProtocolError {
 public:
  using ProtocolError::ProtocolError;
};

struct ParticipantSettings {
  std::string endpoint;         ///< endpoint of the coupler, such as "tcp://127.0.0.1:40321"
  std::string name;             ///< name of this participant in coupler.json
  std::string program;          ///< such as "fem_solver"
  std::string program_version;  ///< empty = version of this library
  std::string scene_hash;       ///< Scene::hash(); empty = settings do not come from the scene
  int dimension = 0;            ///< 2 or 3
  Quantity receives;            ///< structure: force(); soil: displacement()
  Quantity sends;
  double connect_deadline = 30;  ///< [s] until the coupler has answered
  /// Files of keys.hpp: the own secret key and the coupler's public key, when it asks for keys;
  /// empty: GABION_KEY_FILE and GABION_COUPLER_KEY_FILE, else no keys.
  std::string key_file = "";
  std::string coupler_key_file = "";
  /// End this process when the coupler is lost while the solver computes. For programs; a library
  /// inside another program says false and notices the loss when its solver returns.
  bool exit_when_coupler_is_lost = true;
};

/// Data of a solver in the handshake.
struct Introduction {
  std::vector<InterfaceMesh> interfaces;
  std::vector<std::string> probe_names;
  std::vector<double> probes;      ///< values in the initial state, as many as names
  bool keeps_state = false;        ///< requests "save" and "load" will be answered
  bool takes_force_kinds = false;  ///< request "set_force_kinds" will be answered
  InterfaceValues start = {};      ///< displacements in the initial state, where any is not zero
  bool takes_start = false;        ///< request "set_start" will be answered
  bool takes_facets = false;       ///< request "set_facets" will be answered
  std::vector<std::string> changing = {};  ///< interfaces whose facets may change
};

/// The hello of a participant; the connection adds session and process.
Hello hello_of(const ParticipantSettings& settings, const Introduction& introduction);

/// The participant's end of the wire: one coupler, one thread that talks, one that beats.
/// Any failure is final. Destroyed before the run is finished, it tells the coupler.
class Connection final : public RequestSource {
 public:
  explicit Connection(const ParticipantSettings& settings);
  ~Connection() override;
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  Connection(Connection&&) = delete;
  Connection& operator=(Connection&&) = delete;

  /// Introduce the solver to the coupler.
  /// @throws ProtocolError  refused (the message names both values), or no answer in time
  void handshake(const Solver& solver);
  /// Send these data as those of a solver.
  void handshake(const Introduction& introduction);
  bool welcomed() const { return coupler_ != nullptr; }
  /// Settings of the run, as the coupler gave them. Empty before the handshake.
  const Json& run_settings() const { return run_; }
  const ParticipantSettings& settings() const { return settings_; }

  /// Wait for the coupler's next request. Messages that arrived count before a death: "finish" is
  /// returned also when the coupler is gone already.
  /// @throws ProtocolError  the coupler aborted, died, froze, or asked nothing for too long
  /// @throws Interrupted    a signal came, and nothing that happened to the coupler explains it
  Message next_request(std::vector<std::string>* frames) override;
  Message next_request() { return next_request(nullptr); }
  void reply(Message message) override;
  /// Close, after "finish" was answered and the answer is sent.
  void close();

  /// Tell the coupler that this participant cannot continue, or, before the handshake, not start.
  /// Does nothing after another failure.
  void abort(const std::string& reason);
  /// Run an action; when it throws, abort() and throw on, since the coupler has to know.
  template <class Action>
  void guarded(Action action);

 private:
  using Frames = std::vector<std::string>;
  struct Request {
    Message message;
    Frames frames;
  };
  Message await_answer_to_hello();
  std::optional<Request> receive_request(int milliseconds, Attention::Seconds look = {});
  std::optional<Request> look_after_coupler(bool was_silent);
  bool waits_for_last_checkpoint();
  std::optional<Request> last_words();
  [[noreturn]] void fail(const std::string& reason);
  [[noreturn]] void fail_at_start(const std::string& reason);
  bool send(const Message& message);
  void post(const Message& message);

  ParticipantSettings settings_;
  std::string session_;
  std::optional<ClientKeys> keys_;
  std::shared_ptr<SocketContext> context_;
  std::optional<Socket> socket_;  // empty when closed
  bool has_begun_ = false;        // its first step
  std::unique_ptr<Heartbeat> heartbeat_;
  std::shared_ptr<PeerWatch> coupler_;  // the heartbeat's thread updates it
  Deadlines deadlines_;
  Json run_ = Json::object();
  std::uint64_t last_sequence_ = 0;
  std::string last_request_;  // its type
  Attention attention_;       // to the request after it
  std::string failure_;
  Stopwatch since_health_check_;
  std::optional<Stopwatch> since_signal_;        // while the coupler may still ask for the state
  int exceptions_ = std::uncaught_exceptions();  // exceptions in flight when it was made
};

template <class Action>
void Connection::guarded(Action action) {
  try {
    action();
  } catch (const std::exception& problem) {
    abort(problem.what());
    throw;
  } catch (...) {
    abort("an exception of unknown type");
    throw;
  }
}

}  // namespace gabion
