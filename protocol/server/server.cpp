// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/server/server.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "gabion_version.hpp"

namespace gabion {
namespace {

constexpr double awaited_log_period = 3;  // [s]
constexpr double late_hello_wait = 1;     // [s] as long as a launcher waits before it ends the rest

/// Disagreements that are found before the hello is read in full.
std::vector<Mismatch> compare_versions(const Message& hello) {
  const std::string theirs = hello.text("protocol");
  if (major_version(theirs) == major_version(protocol_version)) return {};
  return {{"protocol version", protocol_version, theirs}};
}

std::optional<ServerKeys> keys_of(const ServerSettings& settings) {
  if (settings.key_file.empty()) return std::nullopt;
  return read_server_keys(settings.key_file, settings.clients_file);
}

std::string claimed_name(const Message& hello) {
  const auto name = hello.fields.find("participant");
  return name == hello.fields.end() ? "a participant without name"
                                    : "participant " + shortened(*name);
}

/// End the wait when an awaited participant says that it cannot begin. Others are ignored.
/// @param awaited  loses its name
void require_beginning(const Message& abort, std::vector<std::string>& awaited) {
  const std::string name = text_or_empty(abort, "participant");
  if (std::erase(awaited, name) == 0) return;
  const std::string program = text_or_empty(abort, "program");
  throw Declined(fmt::format("participant \"{}\" ({}) cannot begin: {}", name, program,
                             text_or_empty(abort, "reason")),
                 program);
}

std::string names_of(const std::vector<Expected>& participants) {
  std::vector<std::string> names;
  for (const Expected& expected : participants) names.push_back(expected.name);
  return fmt::format("one of {}", names);
}

}  // namespace

KeyTable server_keys() {
  const KeyTable security{
      "security",
      "Keys of CurveZMQ: only participants with a known key may connect, and all is encrypted.",
      {key::text("key_file",
                 "File of the coupler's secret key, relative to the scene; refused if others may "
                 "read it."),
       key::text("clients_file",
                 "File of the public keys of those that may connect, one or more; relative to the "
                 "scene.")}};
  KeyTable table{"protocol",
                 "Where the coupler listens and how long each wait lasts at most.",
                 {key::text("endpoint",
                            "Address where the coupler listens. `*` takes a free port; "
                            "participants on other machines need tcp://0.0.0.0:PORT or an address "
                            "of this machine.")
                      .or_else(ServerSettings{}.endpoint)}};
  for (const Key& key : deadline_keys()) table.keys.push_back(key);
  table.keys.push_back(key::object("security", security,
                                   "Keys and encryption; none: anybody may connect, and "
                                   "nothing is encrypted.")
                           .or_none());
  return table;
}

ServerSettings read_server_settings(ConfigReader in) {
  ServerSettings settings;
  settings.endpoint = in.text("endpoint");
  settings.deadlines = read_deadlines(in);
  if (auto security = in.optional_object("security")) {
    settings.key_file = security->text("key_file");
    settings.clients_file = security->text("clients_file");
    for (const char* key : {"key_file", "clients_file"}) {
      if (security->text(key).empty()) security->fail(key, "found \"\", allowed: a file");
    }
    security->finish();
  }
  in.finish();
  return settings;
}

Server::Server(const ServerSettings& settings)
    : switchboard_(settings.endpoint, settings.deadlines, keys_of(settings)) {}

std::map<std::string, std::unique_ptr<Solver>> Server::wait_for(
    const std::vector<Expected>& participants, const Json& run) {
  std::vector<std::string> awaited;
  for (const Expected& expected : participants) awaited.push_back(expected.name);
  try {
    return switchboard_.guarded([&] { return greet_all(participants, run, awaited); });
  } catch (const Error& problem) {
    switchboard_.turn_away(problem.what(), awaited, late_hello_wait);
    throw;
  }
}

/// @param awaited  loses the name of each that came
std::map<std::string, std::unique_ptr<Solver>> Server::greet_all(
    const std::vector<Expected>& participants, const Json& run, std::vector<std::string>& awaited) {
  std::map<std::string, std::unique_ptr<Solver>> solvers;
  const Stopwatch waited;
  Stopwatch since_log;
  while (!awaited.empty()) {
    if (const auto arrival = switchboard_.next_arrival()) {
      if (arrival->hello.type == "abort") {
        require_beginning(arrival->hello, awaited);
      } else if (auto hello = read_or_turn_down(*arrival, awaited)) {
        names_.push_back(hello->participant);
        solvers[names_.back()] = greet(arrival->route, std::move(*hello), participants, run);
      }
    }
    require<ProtocolError>(
        waited.seconds() <= switchboard_.deadlines().connect || awaited.empty(), [&] {
          return fmt::format(
              "participants {} did not connect to {} within {:.1f} s (limit {} s, {}){}{}", awaited,
              endpoint(), waited.seconds(), switchboard_.deadlines().connect,
              deadline_option("connect_deadline"), turned_down_.empty() ? "" : "; ", turned_down_);
        });
    if (since_log.seconds() > awaited_log_period) {
      since_log = Stopwatch();
      log::info("waiting for participants {} on {} since {:.0f} s", awaited, endpoint(),
                waited.seconds());
    }
  }
  switchboard_.set_phase("coupling");
  return solvers;
}

/// Read a hello. One in which something is missing or senseless may come from anybody: its sender
/// is told so, and the wait goes on.
/// @param awaited  loses the name of one that is understood
std::optional<Hello> Server::read_or_turn_down(const Switchboard::Arrival& arrival,
                                               std::vector<std::string>& awaited) {
  std::vector<Mismatch> versions;
  std::optional<Hello> hello;
  try {
    versions = compare_versions(arrival.hello);
    if (versions.empty()) hello = read_hello(arrival.hello);
  } catch (const ProtocolError& problem) {
    const std::string who = claimed_name(arrival.hello);
    const std::vector<Mismatch> mismatches = {{"hello", "a complete hello", problem.what()}};
    turned_down_ = fmt::format("{} was refused: {}", who, mismatch_text(mismatches));
    switchboard_.turn_down(arrival.route, who, mismatches);
    return std::nullopt;
  }
  std::erase(awaited, text_or_empty(arrival.hello, "participant"));
  if (!hello) refuse(arrival.route, claimed_name(arrival.hello), versions);
  return hello;
}

void Server::refuse(const std::string& route, const std::string& who,
                    const std::vector<Mismatch>& mismatches) {
  switchboard_.answer(route, refusal(mismatches));
  throw ProtocolError(fmt::format("{} was refused: {}", who, mismatch_text(mismatches)));
}

std::unique_ptr<Solver> Server::greet(const std::string& route, Hello hello,
                                      const std::vector<Expected>& participants, const Json& run) {
  const std::string label = fmt::format("participant \"{}\" ({}, pid {})", hello.participant,
                                        hello.program, hello.process.pid);
  const auto expected =
      std::find_if(participants.begin(), participants.end(),
                   [&hello](const Expected& e) { return e.name == hello.participant; });
  if (expected == participants.end()) {
    refuse(route, label, {{"participant name", names_of(participants), hello.participant}});
  }
  if (switchboard_.has_participant(hello.participant)) {
    refuse(route, label,
           {{"participant name", "\"" + hello.participant + "\" is connected already",
             hello.participant}});
  }
  if (const auto mismatches = compare(*expected, hello); !mismatches.empty()) {
    refuse(route, label, mismatches);
  }
  Welcome welcome;
  welcome.program_version = version;
  welcome.process = this_process();
  welcome.deadlines = switchboard_.deadlines();
  welcome.run = run;
  switchboard_.welcome({.name = hello.participant,
                        .route = route,
                        .session = hello.session,
                        .label = label,
                        .process = hello.process,
                        .sends_heartbeat = hello.sends_heartbeat},
                       to_message(welcome));
  log::info("{} is here{}", label,
            hello.scene_hash.empty() ? ": it gives no hash of its scene, so its settings are not "
                                       "compared"
                                     : "");
  return std::make_unique<RemoteSolver>(switchboard_, std::move(hello));
}

void Server::finish() {
  switchboard_.guarded([&] {
    switchboard_.set_phase("finish");
    std::vector<std::uint64_t> sequences;
    for (const std::string& name : names_) {
      sequences.push_back(switchboard_.send(name, new_message("finish")));
    }
    for (std::size_t i = 0; i < names_.size(); ++i) {
      const Message reply = switchboard_.wait_reply(names_[i], sequences[i]);
      require<ProtocolError>(reply.type == "finished",
                             "participant \"{}\" answered \"finish\" with \"{}\"", names_[i],
                             reply.type);
    }
  });
}

}  // namespace gabion
