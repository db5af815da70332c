// SPDX-License-Identifier: BSD-3-Clause
#include "solver_program/solver_program.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <optional>

#include "common/base/interrupt.hpp"
#include "common/base/last_error.hpp"
#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "common/mechanics/petsc/petsc_session.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "common/program/programs.hpp"
#include "common/run/folder_lock.hpp"
#include "common/run/run_alone.hpp"
#include "common/run/run_record.hpp"
#include "protocol/serve.hpp"
#include "solver_program/ranked_requests.hpp"
#include "solver_program/ranked_solver.hpp"

namespace gabion {

std::vector<Key> alone_keys() {
  const std::string alone = "in a scene without coupler.json";
  return {key::object("time", time_keys(), "Steps of the run.").only(alone),
          key::object("output", output_keys(), "Frames of the run.").only(alone),
          key::object("checkpoint", checkpoint_keys(), "Checkpoints of the run.")
              .or_empty()
              .only(alone)};
}

AloneSettings read_alone_settings(ConfigReader& in) {
  AloneSettings alone;
  alone.time = read_time_settings(in.object("time"));
  auto output = in.object("output");
  alone.output_interval = output.number("interval");
  output.finish();
  alone.checkpoint = read_checkpoint_settings(in);
  return alone;
}

namespace {

std::string coupler_endpoint(const ProgramOptions& options, const MpiSession& session) {
  if (session.launched_with("coupler")) return session.share("coupler", "");
  require<ConfigError>(!options.coupler.empty(),
                       "{}: has a coupler.json, so a coupler has to be part of the launch "
                       "(mpirun … coupler … : … ) or named by --coupler tcp://host:port",
                       options.scene);
  return options.coupler;
}

/// One program's part of a run.
struct SolverRun {
  const ProgramEntry& program;
  const MakeSolver& make;
  const ProgramOptions& options;
  const MpiSession& session;
  const Scene& scene;
  ConfigReader& reader;
};

/// Settings of the connection to the coupler, which do not depend on the scene.
ParticipantSettings wire_settings(const SolverRun& run, const std::string& endpoint) {
  ParticipantSettings settings;
  settings.endpoint = endpoint;
  settings.name = run.options.name;
  settings.program = run.program.name;
  settings.connect_deadline = run.options.connect_deadline;
  settings.key_file = run.options.key_file;
  settings.coupler_key_file = run.options.coupler_key_file;
  return settings;
}

ParticipantSettings participant_settings(const SolverRun& run, const std::string& endpoint) {
  ParticipantSettings settings = wire_settings(run, endpoint);
  if (run.scene.has("coupler.json")) settings.scene_hash = run.scene.hash();
  settings.dimension = static_cast<int>(run.reader.resolved().at("dimension"));
  settings.receives = run.program.sends_force ? displacement() : force();
  settings.sends = run.program.sends_force ? force() : displacement();
  return settings;
}

/// Serve the coupler: the first rank talks to it, the others carry out the same requests.
/// @param welcomed  on the first rank, after the handshake
void serve_on_ranks(MPI_Comm comm, Solver& inner, const ParticipantSettings& settings,
                    const std::function<void(const Connection&)>& welcomed) {
  RankedSolver solver(comm, inner);
  const std::vector<double> probes = solver.probes();
  const InterfaceValues start = solver.start_displacements();
  if (rank_of(comm) != 0) {
    FollowingRequests requests(comm);
    answer_requests(solver, settings.receives, settings.sends, requests);
    return;
  }
  std::optional<Connection> connection;
  try {
    connection.emplace(settings);
    connection->handshake({.interfaces = solver.interfaces(),
                           .probe_names = solver.probe_names(),
                           .probes = probes,
                           .keeps_state = solver.keeps_state(),
                           .takes_force_kinds = solver.takes_force_kinds(),
                           .start = start,
                           .takes_start = solver.takes_start(),
                           .takes_facets = solver.takes_facets(),
                           .changing = changing_interfaces(solver)});
    welcomed(*connection);
  } catch (const std::exception& problem) {
    end_followers(comm, problem.what());
    if (connection) connection->abort(problem.what());
    throw;
  }
  LeadingRequests requests(comm, *connection);
  serve(solver, *connection, requests);
}

/// Tell the coupler why this program cannot begin. @note On the first rank.
void decline(const SolverRun& run, const std::string& endpoint, const std::string& reason) {
  try {
    Connection(wire_settings(run, endpoint)).abort(reason);
  } catch (const std::exception& problem) {
    log::debug("the coupler was not told: {}", problem.what());
  }
}

/// The folder of this program below the results, whose lock file the coupler has signed where it
/// runs on this machine.
void lock_own_folder(const std::string& results, const std::string& folder,
                     const std::string& program, std::vector<FolderLock>& locks) {
  std::filesystem::create_directories(folder);
  locks.emplace_back(results, FolderLock::Kind::beside);
  locks.emplace_back(folder, FolderLock::Kind::alone);
  locks.back().sign(program);
}

void follow_coupler(const SolverRun& run, const std::string& endpoint) {
  const ProgramOptions& options = run.options;
  const bool is_main = options.name == run.program.participant;
  const std::string folder =
      options.check ? "" : options.output + "/" + (is_main ? run.program.folder : options.name);
  std::unique_ptr<Solver> solver;
  try {
    solver = run.make(run.scene, run.reader, run.session.comm(), folder, nullptr);
  } catch (const std::exception& problem) {
    log::last_error(problem.what());
    if (run.session.is_root()) decline(run, endpoint, problem.what());
    throw;
  }
  interrupt::install();  // all ranks: the first one ends the run
  std::vector<FolderLock> locks;
  const auto welcomed = [&](const Connection& connection) {
    if (options.check || connection.run_settings().value("check", Json()) == true) return;
    lock_own_folder(options.output, folder, run.program.name, locks);
    write_json_file(folder + "/resolved_config.json", {{run.program.file, run.reader.resolved()}});
  };
  try {
    serve_on_ranks(run.session.comm(), *solver, participant_settings(run, endpoint), welcomed);
  } catch (const NeverBegun& problem) {
    if (run.session.launched_with("coupler")) log::last_error_of_another(problem.what());
    throw;
  }
}

/// The checkpoint from which the run continues, if any; each rank reads it, but for the solver's
/// file.
std::optional<Checkpoint> load_checkpoint(const SolverRun& run) {
  const ProgramOptions& options = run.options;
  if (options.restart.empty()) return std::nullopt;
  return Checkpoints::load(options.restart, options.output, run.program.name, run.scene);
}

/// @param checkpoint  to continue from, if any
void drive_alone(const SolverRun& run, RunRecord& record, const Checkpoint* checkpoint) {
  const ProgramOptions& options = run.options;
  const ProgramEntry& program = run.program;
  const MPI_Comm comm = run.session.comm();
  AloneSettings alone;
  const auto inner = run.make(run.scene, run.reader, comm, record.path(program.folder), &alone);
  RankedSolver solver(comm, *inner);
  record.write_json("resolved_config.json", {{program.file, run.reader.resolved()}});
  if (!solver.interfaces().empty()) {
    log::info("interfaces: this scene has no coupler, so their surfaces stay at rest");
  }
  std::optional<RestartPoint> start;
  if (checkpoint != nullptr) {
    solver.load_state(checkpoint->state_of(program.folder));
    start = restart_point(options.restart, *checkpoint);
  }
  interrupt::install();
  Checkpoints checkpoints(
      alone.checkpoint, run.scene,
      {.folder = options.output,
       .kind = program.name,
       .writes = run.session.is_root(),
       .solvers = {{program.folder,
                    [&](const std::string& path) { return solver.save_state_to(path); }}},
       .agree = [comm](int value) { return static_cast<int>(max_over_ranks(comm, value)); }},
      std::move(start));
  run_alone(solver, alone.time, alone.output_interval, record, &checkpoints);
}

void drive_alone(const SolverRun& run) {
  const auto checkpoint = load_checkpoint(run);
  RunRecord record(run.options.output, run.program.name, run.session.is_root());
  MPI_Barrier(run.session.comm());
  try {
    drive_alone(run, record, checkpoint ? &*checkpoint : nullptr);
  } catch (const std::exception& error) {
    record.write_failure(error.what());
    throw;
  }
}

}  // namespace

void run_solver_program(const SolverProgram& program, const ProgramOptions& options,
                        const MpiSession& session) {
  const ProgramEntry& entry = program_entry(program.name);
  const PetscSession petsc(session.comm());
  const Scene scene(options.scene, options.overrides);
  ConfigReader reader = scene.reader(entry.file, program.keys);
  const SolverRun run{entry, program.make, options, session, scene, reader};
  const bool is_alone = !scene.has("coupler.json") && options.coupler.empty();
  const bool has_coupler = session.launched_with("coupler") || !options.coupler.empty();
  if (options.check && (is_alone || !has_coupler)) {
    AloneSettings alone;
    const auto solver =
        program.make(scene, reader, session.comm(), "", is_alone ? &alone : nullptr);
    solver->summary();  // refuses a soil that could begin only beside a structure that is not here
    if (is_alone) load_checkpoint(run);
    log::info("{}: valid", scene.path(entry.file));
  } else if (is_alone) {
    drive_alone(run);
  } else {
    follow_coupler(run, coupler_endpoint(options, session));
  }
}

}  // namespace gabion
