// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/run/solver.hpp"
#include "common/settings/config_reader.hpp"
#include "protocol/server/remote_solver.hpp"
#include "protocol/server/switchboard.hpp"
#include "protocol/wire/deadlines.hpp"
#include "protocol/wire/handshake.hpp"

namespace gabion {

/// Error: a participant says that it cannot begin.
class Declined : public ConfigError {
 public:
  Declined(const std::string& message, std::string program)
      : ConfigError(message), program_(std::move(program)) {}
  /// Program that the message names; a solver of this project has printed its reason itself.
  const std::string& program() const { return program_; }

 private:
  std::string program_;
};

struct ServerSettings {
  /// Endpoint to listen at; `*` takes a free port. Other machines need tcp://0.0.0.0:PORT or an
  /// address of this machine, and better keys.
  std::string endpoint = "tcp://127.0.0.1:*";
  Deadlines deadlines;
  /// Files of keys.hpp: the coupler's secret key, and the public keys of those that may connect.
  /// Both empty: anybody may connect, and nothing is encrypted.
  std::string key_file = "";
  std::string clients_file = "";
};

/// The object "protocol" of coupler.json: "endpoint", "security" and the deadlines. Calls finish().
ServerSettings read_server_settings(ConfigReader in);
KeyTable server_keys();

/// The coupler's end of the wire.
///
///     Server server(settings);                           // listens; give server.endpoint() away
///     auto solvers = server.wait_for(expected, run);     // handshake
///     ... solvers["soil"]->solve_step(...) ...
///     server.finish();                                   // participants end with success
///
/// Destroyed without finish(), it tells the participants that the run has failed.
class Server {
 public:
  explicit Server(const ServerSettings& settings);

  /// The actual endpoint, such as "tcp://127.0.0.1:40321".
  const std::string& endpoint() const { return switchboard_.endpoint(); }

  /// Wait until all these participants are here. Logs every few seconds who is awaited. Where one
  /// does not fit or cannot begin, those that come up to a second later are told.
  /// @param run  settings of the run for the participants: end time, dt, folders, ...
  /// @return     name -> RemoteSolver; must not outlive the server
  /// @throws ProtocolError  a participant does not fit (both values are named), or is late, or lost
  /// @throws Declined       a participant says that it cannot begin
  std::map<std::string, std::unique_ptr<Solver>> wait_for(const std::vector<Expected>& participants,
                                                          const Json& run = Json::object());

  /// Defer signals, see Switchboard::defer_signals.
  void defer_signals() { switchboard_.defer_signals(); }

  /// Log waits, see Switchboard::log_waits.
  void log_waits() { switchboard_.log_waits(); }

  /// End the complete run: every participant ends with success.
  void finish();

  /// Tell all participants that the run has failed, and why.
  void abort(const std::string& reason) { switchboard_.abort(reason); }

  /// Set the phase of the coupler, as the participants' messages name it.
  void set_phase(const std::string& phase) { switchboard_.set_phase(phase); }

 private:
  std::map<std::string, std::unique_ptr<Solver>> greet_all(
      const std::vector<Expected>& participants, const Json& run,
      std::vector<std::string>& awaited);
  std::optional<Hello> read_or_turn_down(const Switchboard::Arrival& arrival,
                                         std::vector<std::string>& awaited);
  [[noreturn]] void refuse(const std::string& route, const std::string& who,
                           const std::vector<Mismatch>& mismatches);
  std::unique_ptr<Solver> greet(const std::string& route, Hello hello,
                                const std::vector<Expected>& participants, const Json& run);

  Switchboard switchboard_;
  std::vector<std::string> names_;
  std::string turned_down_;  // who it was last, and why
};

}  // namespace gabion
