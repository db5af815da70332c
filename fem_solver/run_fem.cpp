// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/run_fem.hpp"

#include "common/base/log.hpp"
#include "common/base/run_alone.hpp"
#include "common/mechanics/petsc/petsc_session.hpp"
#include "common/mechanics/ranks/ranked_solver.hpp"
#include "fem_solver/fem_solver.hpp"
#include "protocol/serve.hpp"

namespace gabion {

namespace {

std::string coupler_endpoint(const ProgramOptions& options, const MpiSession& session) {
  if (session.launched_with("coupler")) return session.share("coupler", "");
  require<ConfigError>(!options.coupler.empty(),
                       options.scene + ": has a coupler.json, so a coupler has to be part of the "
                                       "launch or named by --coupler");
  return options.coupler;
}

void follow_coupler(Solver& solver, int dim, const Scene& scene, const ProgramOptions& options,
                    const MpiSession& session) {
  ParticipantSettings settings;
  settings.endpoint = coupler_endpoint(options, session);
  settings.name = options.name;
  settings.program = "fem_solver";
  settings.scene_hash = scene.hash();
  settings.dimension = dim;
  settings.receives = force();
  settings.sends = displacement();
  drive_ranks(session.comm(), solver, [&](Solver& ranked) {
    Connection connection(settings);
    serve(ranked, connection);
  });
}

}  // namespace

void run_fem(const ProgramOptions& options, const MpiSession& session) {
  const PetscSession petsc(session.comm());
  const Scene scene(options.scene, options.overrides);
  ConfigReader reader = scene.reader("fem.json");
  const bool is_alone = !scene.has("coupler.json");
  fem::AloneSettings alone;
  if (options.check) {
    make_fem_solver(scene, reader, session.comm(), "", is_alone ? &alone : nullptr);
    log::info("{}: valid", scene.path("fem.json"));
    return;
  }
  if (is_alone) {
    RunRecord record(options.output, "fem_solver", session.is_root());
    const auto solver =
        make_fem_solver(scene, reader, session.comm(), record.path("fem"), &alone);
    record.write_json("resolved_config.json", {{"fem.json", reader.resolved()}});
    run_alone(*solver, alone.time, alone.output_interval, record);
    return;
  }
  const int dim = fem::read_dimension(reader);
  const auto solver = make_fem_solver(scene, reader, session.comm(), options.output + "/fem");
  follow_coupler(*solver, dim, scene, options, session);
}

}  // namespace gabion
