// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/run_coupler.hpp"

#include <fmt/format.h>

#include "common/base/log.hpp"
#include "common/base/run_record.hpp"
#include "coupler/coupling_loop.hpp"
#include "common/base/interrupt.hpp"
#include "protocol/server.hpp"

namespace gabion {

std::vector<Expected> expected_participants(const CouplerSettings& settings,
                                            const std::string& scene_hash) {
  std::vector<Expected> result;
  for (const ParticipantRole& role : settings.participants) {
    Expected expected;
    expected.name = role.name;
    expected.scene_hash = scene_hash;
    expected.receives = role.sends_force ? displacement() : force();
    expected.sends = role.sends_force ? force() : displacement();
    for (const InterfaceSettings& interface : settings.interfaces) {
      if (interface.soil == role.name || interface.structure == role.name) {
        expected.interfaces.push_back(interface.name);
      }
    }
    result.push_back(expected);
  }
  return result;
}

namespace {

void couple(Server& server, const CouplerSettings& settings, const std::string& scene_hash,
            RunRecord& files) {
  const Json run = {{"output", files.folder()},
                    {"end", settings.time.end},
                    {"dt", settings.time.dt},
                    {"output_interval", settings.output_interval}};
  const auto solvers = server.wait_for(expected_participants(settings, scene_hash), run);
  std::vector<NamedSolver> participants;
  for (const auto& [name, solver] : solvers) participants.push_back({name, *solver});
  CouplingLoop loop(settings, participants, files);
  loop.run();
  server.finish();
  log::info("done: {}", files.folder());
}

}  // namespace

void run_coupler(const ProgramOptions& options, const MpiSession& session) {
  require<ConfigError>(
      session.size() == 1,
      fmt::format("coupler: launched with {} processes, allowed: 1", session.size()));
  const Scene scene(options.scene, options.overrides);
  const ConfigReader reader = scene.reader("coupler.json");
  CouplerSettings settings = read_coupler_settings(reader);
  if (options.check) {
    log::info("{}: valid", scene.path("coupler.json"));
    return;
  }
  if (!options.coupler.empty()) settings.server.endpoint = options.coupler;

  RunRecord files(options.output, "coupler");
  log::also_to_file(files.path("coupler.log"));
  files.write_json("resolved_config.json", {{"coupler.json", reader.resolved()}});
  interrupt::install();
  Server server(settings.server);
  session.share("coupler", server.endpoint());
  try {
    couple(server, settings, scene.hash(), files);
  } catch (const std::exception& error) {
    server.abort(error.what());
    throw;
  }
}

}  // namespace gabion
