// SPDX-License-Identifier: BSD-3-Clause
#include "solver_program/solver_program.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <optional>

#include "common/base/interrupt.hpp"
#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "common/mechanics/petsc/petsc_session.hpp"
#include "common/mechanics/ranks/ranked_solver.hpp"
#include "common/mechanics/ranks/ranked_state.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "common/run/run_alone.hpp"
#include "common/run/run_record.hpp"
#include "common/settings/describe_keys.hpp"
#include "protocol/serve.hpp"

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

void follow_coupler(const SolverProgram& program, const ProgramOptions& options,
                    const MpiSession& session, const Scene& scene, ConfigReader& reader,
                    const std::string& endpoint) {
  const std::string own = options.name == program.participant ? program.folder : options.name;
  const std::string folder = options.check ? "" : options.output + "/" + own;
  const auto solver = program.make(scene, reader, session.comm(), folder, nullptr);
  ParticipantSettings settings;
  settings.endpoint = endpoint;
  settings.name = options.name;
  settings.program = program.name;
  if (scene.has("coupler.json")) settings.scene_hash = scene.hash();
  settings.dimension = static_cast<int>(reader.resolved().at("dimension"));
  settings.receives = program.receives;
  settings.sends = program.sends;
  settings.connect_deadline = options.connect_deadline;
  settings.key_file = options.key_file;
  settings.coupler_key_file = options.coupler_key_file;
  interrupt::install();  // all ranks: the first one ends the run
  drive_ranks(session.comm(), *solver, [&](Solver& ranked) {
    Connection connection(settings);
    serve(ranked, connection, [&] {
      if (options.check || connection.run_settings().value("check", false)) return;
      std::filesystem::create_directories(folder);
      write_json_file(folder + "/resolved_config.json", {{program.file, reader.resolved()}});
    });
  });
}

/// The checkpoint that the run goes on from, if any; each rank reads it.
std::optional<Checkpoint> load_checkpoint(const SolverProgram& program,
                                          const ProgramOptions& options, const Scene& scene) {
  if (options.restart.empty()) return std::nullopt;
  return Checkpoints::load(options.restart, options.output, program.name, scene);
}

void drive_alone(const SolverProgram& program, const ProgramOptions& options,
                 const MpiSession& session, const Scene& scene, ConfigReader& reader) {
  const MPI_Comm comm = session.comm();
  const auto checkpoint = load_checkpoint(program, options, scene);
  RunRecord record(options.output, program.name, session.is_root());
  MPI_Barrier(comm);
  AloneSettings alone;
  const auto solver = program.make(scene, reader, comm, record.path(program.folder), &alone);
  record.write_json("resolved_config.json", {{program.file, reader.resolved()}});
  if (!solver->interfaces().empty()) {
    log::info("interfaces: no coupler in this scene, their surfaces stay where they are");
  }
  std::optional<RestartPoint> start;
  if (checkpoint) {
    solver->load_state(scatter_state(comm, checkpoint->state_of(program.folder)));
    start = restart_point(options.restart, *checkpoint);
  }
  interrupt::install();
  Checkpoints checkpoints(
      alone.checkpoint, scene,
      {.folder = options.output,
       .kind = program.name,
       .writes = session.is_root(),
       .solvers = {{program.folder, [&] { return gather_state(comm, solver->save_state()); }}},
       .agree = [comm](int value) { return static_cast<int>(max_over_ranks(comm, value)); }},
      std::move(start));
  run_alone(*solver, alone.time, alone.output_interval, record, &checkpoints);
}

}  // namespace

void run_solver_program(const SolverProgram& program, const ProgramOptions& options,
                        const MpiSession& session) {
  if (!options.describe_keys.empty()) {
    if (session.is_root()) describe_keys(program.keys, program.file, options.describe_keys);
    return;
  }
  const PetscSession petsc(session.comm());
  const Scene scene(options.scene, options.overrides);
  ConfigReader reader = scene.reader(program.file, program.keys);
  const bool is_alone = !scene.has("coupler.json") && options.coupler.empty();
  const bool has_coupler = session.launched_with("coupler") || !options.coupler.empty();
  if (options.check && (is_alone || !has_coupler)) {
    AloneSettings alone;
    program.make(scene, reader, session.comm(), "", is_alone ? &alone : nullptr);
    if (is_alone) load_checkpoint(program, options, scene);
    log::info("{}: valid", scene.path(program.file));
  } else if (is_alone) {
    drive_alone(program, options, session, scene, reader);
  } else {
    const std::string endpoint = coupler_endpoint(options, session);
    follow_coupler(program, options, session, scene, reader, endpoint);
  }
}

}  // namespace gabion
