// SPDX-License-Identifier: BSD-3-Clause
// A soil or structure without mechanics that misbehaves on demand:
//     fake_participant NAME ENDPOINT [KIND PHASE] [--version V] [--pause S] [--seconds S]
//         [--connect-deadline S]
// NAME is soil or structure; KIND and PHASE are those of Misdeed. Exit codes are those of the
// programs.
#include <CLI/CLI.hpp>
#include <set>

#include "common/base/log.hpp"
#include "liar.hpp"
#include "protocol/participant/connection.hpp"
#include "protocol/serve.hpp"

namespace {

using namespace gabion;
using test::Misdeed;

Hello make_hello(const std::string& name, const std::string& version) {
  Hello hello;
  hello.protocol = version;
  hello.participant = name;
  hello.program = "fake_participant";
  hello.program_version = "0";
  hello.session = std::to_string(getpid());
  hello.dimension = 2;
  hello.receives = name == "soil" ? displacement() : force();
  hello.sends = name == "soil" ? force() : displacement();
  const test::FakeSolver solver(name == "soil", {}, 0);
  hello.interfaces = solver.interfaces();
  hello.probe_names = solver.probe_names();
  hello.probes = solver.probes();
  hello.sends_heartbeat = false;
  hello.process = this_process();
  return hello;
}

/// Serve with this project's own connection and heartbeat.
int serve_as(const std::string& name, const std::string& endpoint, const Misdeed& misdeed,
             double pause, double connect_deadline) {
  ParticipantSettings settings;
  settings.endpoint = endpoint;
  settings.name = name;
  settings.program = "fake_participant";
  settings.dimension = 2;
  settings.receives = name == "soil" ? displacement() : force();
  settings.sends = name == "soil" ? force() : displacement();
  settings.connect_deadline = connect_deadline;
  try {
    test::FakeSolver solver(name == "soil", misdeed, pause);
    Connection connection(settings);
    solver.at("handshake");
    log::start(name, log::Level::debug, true);  // says when the coupler has answered
    serve(solver, connection);
  } catch (const Error& problem) {
    std::puts(fmt::format("[{}] error: {}", name, problem.what()).c_str());
    return problem.exit_code();
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  std::string name;
  std::string endpoint;
  std::string version = protocol_version;
  double pause = 0, connect_deadline = 2;
  Misdeed misdeed;
  CLI::App app("A participant that misbehaves.");
  app.add_option("name", name)->required()->check(CLI::IsMember({"soil", "structure"}));
  app.add_option("endpoint", endpoint)->required();
  app.add_option("kind", misdeed.kind);
  app.add_option("phase", misdeed.phase);
  app.add_option("--version", version);
  app.add_option("--pause", pause);
  app.add_option("--connect-deadline", connect_deadline);
  app.add_option("--seconds", misdeed.seconds);
  CLI11_PARSE(app, argc, argv);
  const std::set<std::string> honest = {"none", "killed", "stopped", "slow", "announced"};
  if (honest.contains(misdeed.kind) && version == protocol_version) {
    return serve_as(name, endpoint, misdeed, pause, connect_deadline);
  }
  return test::Liar(endpoint, make_hello(name, version), misdeed, connect_deadline).run();
}
