// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/run_mpm.hpp"

#include <fmt/format.h>

#include "common/base/log.hpp"
#include "common/base/run_alone.hpp"
#include "common/mechanics/petsc/petsc_session.hpp"
#include "mpm_solver/mpm_config.hpp"
#include "mpm_solver/mpm_solver.hpp"

namespace gabion {

namespace {

template <int dim>
void run_dim(const ProgramOptions& options, const MpiSession& session, const Scene& scene,
             ConfigReader& reader) {
  const bool alone = !scene.has("coupler.json");
  AloneSettings alone_settings;
  auto settings = read_mpm_settings<dim>(scene, reader, alone ? &alone_settings : nullptr);
  if (options.check) {
    MpmSolver<dim> solver(session.comm(), std::move(settings), "");
    log::info("{}: valid", scene.path("mpm.json"));
    return;
  }
  if (alone) {
    RunRecord record(options.output, "mpm_solver", session.is_root());
    record.write_json("resolved_config.json", {{"mpm.json", reader.resolved()}});
    MpmSolver<dim> solver(session.comm(), std::move(settings), record.path("mpm"));
    run_alone(solver, alone_settings.time, alone_settings.output_interval, record);
    return;
  }
}

}  // namespace

void run_mpm(const ProgramOptions& options, const MpiSession& session) {
  const PetscSession petsc(session.comm());
  const Scene scene(options.scene, options.overrides);
  ConfigReader reader = scene.reader("mpm.json");
  if (reader.integer("dimension", between(2, 3)) == 2) {
    run_dim<2>(options, session, scene, reader);
  } else {
    run_dim<3>(options, session, scene, reader);
  }
}

}  // namespace gabion
