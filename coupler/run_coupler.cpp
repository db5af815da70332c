// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/run_coupler.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <set>

#include "common/base/interrupt.hpp"
#include "common/base/last_error.hpp"
#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "common/run/results_folder.hpp"
#include "common/run/run_record.hpp"
#include "common/settings/describe_keys.hpp"
#include "coupler/checks/participant_check.hpp"
#include "coupler/checks/run_check.hpp"
#include "coupler/checks/scene_check.hpp"
#include "coupler/checks/surface_check.hpp"
#include "coupler/coupling_loop.hpp"
#include "protocol/channel/keys.hpp"
#include "protocol/server/server.hpp"

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

/// A participant may run in another folder than the coupler.
Json run_settings(const CouplerSettings& settings, const std::string& output) {
  return {{"output", std::filesystem::absolute(output).lexically_normal().string()},
          {"end", settings.time.end},
          {"dt", settings.time.dt},
          {"output_interval", settings.output_interval},
          {"checkpoints", true}};
}

/// Log the last error; a solver of the launch that cannot begin has shown its reason at this
/// terminal already.
void say_last(const std::exception& error, const MpiSession& session) {
  const auto* declined = dynamic_cast<const Declined*>(&error);
  if (declined != nullptr && session.launched_with(declined->program())) {
    log::last_error_to_file(error.what());
  } else {
    log::last_error(error.what());
  }
}

void warn_all(const std::vector<std::string>& warnings) {
  for (const std::string& text : warnings) log::warn("{}", text);
}

/// Do `--check`: compare the files and, if other programs run, do all that comes before the first
/// step.
void check_scene(const CouplerSettings& settings, const Scene& scene,
                 const std::vector<ProgramEntry>& files, const ProgramOptions& options,
                 const MpiSession& session) {
  if (!options.restart.empty()) {
    Checkpoints::load(options.restart, options.output, "coupler", scene);
  }
  warn_all(check_attendance(scene, settings, files));
  if (session.is_only_process() && options.coupler.empty()) {
    log::info("{}: valid", scene.path("coupler.json"));
    return;
  }
  std::vector<Expected> expected = expected_participants(settings, scene.hash());
  const std::set<std::string> here = participants_here(settings, files);
  std::erase_if(expected, [&](const Expected& other) { return !here.contains(other.name); });
  interrupt::install();
  Server server(settings.server);
  session.share("coupler", server.endpoint());
  Json run = run_settings(settings, options.output);
  run["check"] = true;
  try {
    check_run(server, settings, expected, run, scene);
  } catch (const std::exception& error) {
    say_last(error, session);
    server.abort(error.what());
    throw;
  }
}

/// Lists the participants for scripts/run, which starts the commands, and the programs whose files
/// the scene has. Nothing is started for an endpoint where nobody can listen.
void list_participants(const CouplerSettings& settings, const Scene& scene) {
  Socket::bind_router(make_socket_context(), settings.server.endpoint);
  std::vector<std::string> items = {settings.server.endpoint};
  const std::vector<ProgramEntry> own =
      files_read(scene, settings, [](const std::string&) { return true; });
  for (const ParticipantRole& role : settings.participants) {
    const auto program = std::find_if(own.begin(), own.end(), [&](const ProgramEntry& entry) {
      return entry.participant == role.name;
    });
    items.insert(items.end(), {role.name, program == own.end() ? "" : program->name,
                               std::to_string(role.command.size())});
    items.insert(items.end(), role.command.begin(), role.command.end());
  }
  for (const std::string& item : items) std::fwrite(item.c_str(), 1, item.size() + 1, stdout);
}

/// A check found faults, as its table says.
class CheckFailed : public Error {
 public:
  using Error::Error;
  int exit_code() const override { return 1; }
};

constexpr double check_answer_deadline = 60;  // [s]

/// A participant under test that hangs is reported soon, unless coupler.json says how long to wait.
ServerSettings server_of_check(const CouplerSettings& settings, const Scene& scene) {
  ServerSettings server = settings.server;
  ConfigReader file = scene.reader("coupler.json", coupler_keys());
  if (!file.object("protocol").has("answer_deadline")) {
    server.deadlines.answer = check_answer_deadline;
  }
  return server;
}

void print_row(const CheckRow& row) {
  std::fputs(row_text(row).c_str(), stdout);
  std::fflush(stdout);
}

/// Check one participant, without the others of the scene and without coupling.
void check_one(const CouplerSettings& settings, const Scene& scene, const ProgramOptions& options,
               const MpiSession& session) {
  const std::string& name = options.check_participant;
  std::vector<Expected> expected = expected_participants(settings, scene.hash());
  std::erase_if(expected, [&](const Expected& other) { return other.name != name; });
  require<ConfigError>(!expected.empty(),
                       "--check-participant: found \"{}\", allowed: a participant of "
                       "coupler.json",
                       name);
  const bool gets_force = expected.front().receives == force();
  const double amplitude = options.amplitude > 0 ? options.amplitude : gets_force ? 1e-3 : 1e-6;
  interrupt::install();
  const ServerSettings server_settings = server_of_check(settings, scene);
  Server server(server_settings);
  session.share("coupler", server.endpoint());
  log::info("waiting for participant \"{}\" on {}, and at most {:g} s for each of its answers",
            name, server.endpoint(), server_settings.deadlines.answer);
  const auto solvers = server.wait_for(expected, run_settings(settings, options.output));
  server.log_waits();
  const CheckSettings check{
      .dt = settings.time.dt, .amplitude = amplitude, .report = print_row, .finish = [&server] {
        server.finish();
      }};
  const bool passed = all_passed(check_participant(*solvers.at(name), check));
  if (!passed)
    throw CheckFailed(
        fmt::format("participant \"{}\" failed a check and would spoil a coupled run", name));
}

/// Whether all participants save their states; if not, says who does not.
bool all_keep_states(const std::vector<NamedSolver>& participants,
                     const std::optional<Checkpoint>& restart) {
  for (const NamedSolver& participant : participants) {
    if (participant.solver.keeps_state()) continue;
    const std::string reason =
        fmt::format("participant \"{}\" does not save its state", participant.name);
    require<ConfigError>(!restart, "--restart: " + reason);
    log::info("no checkpoints: {}", reason);
    return false;
  }
  return true;
}

/// Parts of a coupled run.
struct CoupledRun {
  const CouplerSettings& settings;
  const Scene& scene;
  const ProgramOptions& options;
  const std::optional<Checkpoint>& restart;
};

void couple(Server& server, const CoupledRun& run, RunRecord& files) {
  const auto& [settings, scene, options, restart] = run;
  const auto solvers = server.wait_for(expected_participants(settings, scene.hash()),
                                       run_settings(settings, files.folder()));
  std::vector<NamedSolver> participants;
  std::vector<InterfaceMesh> surfaces;
  Checkpoints::Parts parts{.folder = files.folder(), .kind = files.kind(), .solvers = {}};
  for (const auto& entry : solvers) {
    Solver& solver = *entry.second;
    participants.push_back({entry.first, solver});
    for (InterfaceMesh& mesh : solver.interfaces()) surfaces.push_back(std::move(mesh));
    parts.solvers.emplace_back(
        entry.first, [&solver](const std::string& path) { return solver.save_state_to(path); });
  }
  warn_all(rounding_warnings(settings.coupling, surfaces, scene.path("coupler.json")));
  std::optional<Checkpoints> checkpoints;
  if (all_keep_states(participants, restart)) {
    std::optional<RestartPoint> start;
    if (restart) {
      for (const auto& [name, solver] : solvers) solver->load_state(restart->state_of(name));
      start = restart_point(options.restart, *restart);
    }
    checkpoints.emplace(settings.checkpoint, scene, parts, start);
    server.defer_signals();
  }
  CouplingLoop loop(settings, participants, files, checkpoints ? &*checkpoints : nullptr);
  loop.run();
  server.finish();
  log::info("done: {}", files.folder());
}

}  // namespace

void describe_coupler_keys(const std::string& form) {
  describe_keys(coupler_keys(), "coupler.json", form);
}

void run_coupler(const ProgramOptions& options, const MpiSession& session) {
  require<ConfigError>(session.size() == 1, "coupler: launched with {} processes, allowed: 1",
                       session.size());
  if (!options.make_keys.empty()) {
    make_keys(options.make_keys);
    log::info("wrote {0} (secret: keep it) and {0}.pub (public: give it away)", options.make_keys);
    return;
  }
  const Scene scene(options.scene, options.overrides);
  const ConfigReader reader = scene.reader("coupler.json", coupler_keys());
  CouplerSettings settings = read_coupler_settings(reader);
  for (std::string* file : {&settings.server.key_file, &settings.server.clients_file}) {
    if (!file->empty()) *file = scene.path(*file);
  }
  if (!options.coupler.empty()) settings.server.endpoint = options.coupler;
  if (options.list_participants) {
    const bool runs = !options.check && options.check_participant.empty();
    if (runs) check_results_folder(options.output, "coupler");
    return list_participants(settings, scene);
  }
  if (!options.check_participant.empty()) {
    return check_one(settings, scene, options, session);
  }
  const std::vector<ProgramEntry> read = files_read(scene, settings, [&](const std::string& name) {
    return session.launched_with(name) || (options.check && session.is_only_process());
  });
  const std::vector<std::string> warnings = check_files(scene, settings, read);
  if (options.check) {
    warn_all(warnings);
    return check_scene(settings, scene, read, options, session);
  }

  std::optional<Checkpoint> restart;
  if (!options.restart.empty()) {
    restart = Checkpoints::load(options.restart, options.output, "coupler", scene);
  }
  RunRecord files(options.output, "coupler");
  log::also_to_file(files.path("coupler.log"));
  warn_all(warnings);
  files.write_json("resolved_config.json", {{"coupler.json", reader.resolved()}});
  interrupt::install();
  Server server(settings.server);
  session.share("coupler", server.endpoint());
  try {
    couple(server, {settings, scene, options, restart}, files);
  } catch (const std::exception& error) {
    say_last(error, session);
    files.write_failure(error.what());
    server.abort(error.what());
    throw;
  }
}

}  // namespace gabion
