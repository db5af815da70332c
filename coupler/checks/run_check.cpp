// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/checks/run_check.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "common/base/log.hpp"
#include "coupler/checks/surface_check.hpp"
#include "coupler/step/start.hpp"

namespace gabion {

namespace {

using Solvers = std::map<std::string, std::unique_ptr<Solver>>;

/// Size of a model in words, from the numbers of a summary.
std::string sizes_text(const Json& summary) {
  std::vector<std::string> words;
  for (const char* key :
       {"points", "nodes", "cells", "elements", "unknowns", "grid_nodes", "grid_cells"}) {
    const auto found = summary.find(key);
    if (found == summary.end() || !found->is_number_integer()) continue;
    std::string name = key;
    std::replace(name.begin(), name.end(), '_', ' ');
    words.push_back(fmt::format("{} {}", found->get<std::int64_t>(), name));
  }
  return words.empty() ? "does not tell its size" : fmt::format("{}", fmt::join(words, ", "));
}

/// The interfaces of which both participants are there.
std::vector<InterfaceSettings> shared_interfaces(const CouplerSettings& settings,
                                                 const Solvers& solvers) {
  std::vector<InterfaceSettings> shared;
  for (const InterfaceSettings& entry : settings.interfaces) {
    bool complete = true;
    for (const std::string& name : {entry.soil, entry.structure}) {
      if (solvers.contains(name)) continue;
      complete = false;
      log::warn("interface {}: the surface of {} is not known here, so its fit is not checked",
                entry.name, name);
    }
    if (complete) shared.push_back(entry);
  }
  return shared;
}

/// Check the start: soils check theirs where the structures begin.
void check_start(const CouplerSettings& settings, const Solvers& solvers, const InterfaceMap& map) {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(map.size());
  for (const ParticipantRole& role : settings.participants) {
    if (!role.sends_force) put_start(*solvers.at(role.name), map.layout(role.name), x);
  }
  if (x.isZero(0)) return;
  const Eigen::VectorXd u = map.soil_displacement(x);
  for (const ParticipantRole& role : settings.participants) {
    if (role.sends_force) tell_start(*solvers.at(role.name), map.layout(role.name), u);
  }
}

void check_surfaces(const CouplerSettings& settings, const Solvers& solvers, const Scene& scene) {
  const std::vector<InterfaceSettings> shared = shared_interfaces(settings, solvers);
  std::map<std::string, std::vector<InterfaceMesh>> meshes;
  std::vector<InterfaceMesh> all;
  for (const auto& [name, solver] : solvers) {
    for (const InterfaceMesh& mesh : solver->interfaces()) {
      all.push_back(mesh);
      const bool is_shared =
          std::any_of(shared.begin(), shared.end(),
                      [&](const InterfaceSettings& entry) { return entry.name == mesh.name; });
      if (is_shared) meshes[name].push_back(mesh);
    }
  }
  for (const std::string& text :
       rounding_warnings(settings.coupling, all, scene.path("coupler.json"))) {
    log::warn("{}", text);
  }
  if (shared.empty()) return;
  const InterfaceMap map(shared, meshes, settings.coupling.mapping);  // says how they fit
  log::info("{}D, {} unknowns on the coupled surfaces", map.dim(), map.size());
  if (shared.size() == settings.interfaces.size()) check_start(settings, solvers, map);
}

void log_size(const CouplerSettings& settings, const Solvers& solvers) {
  std::int64_t frame_bytes = 0;
  std::string others;  // participants that do not say how large their frames are
  for (const auto& [name, solver] : solvers) {
    const Json summary = solver->summary();
    log::info("{}: {}", name, sizes_text(summary));
    const auto bytes = summary.find("frame_bytes");
    if (bytes != summary.end() && bytes->is_number_integer()) {
      frame_bytes += bytes->get<std::int64_t>();
    } else {
      others += ", without those of " + name;
    }
  }
  const RunSize size = run_size(settings.time, settings.output_interval);
  log::info("time: {} steps of {:g} s to {:g} s, {} frames", size.steps, settings.time.dt,
            settings.time.end, size.frames);
  log::info("frames take at most {:.3g} MB on disk, uncompressed, at the sizes of the start{}",
            1e-6 * static_cast<double>(frame_bytes) * static_cast<double>(size.frames), others);
}

}  // namespace

RunSize run_size(const TimeSettings& time, double output_interval) {
  constexpr double off_raster = 1e-9;  // a remainder below this share is round-off
  const auto pieces = [&](double length) {
    return std::ceil(time.end / length * (1 - off_raster));
  };
  // The frames of an interval may be more than an integer counts; the steps are at most 1e15.
  const double steps = pieces(time.dt), frames = 1 + std::min(steps, pieces(output_interval));
  return {static_cast<std::int64_t>(steps), static_cast<std::int64_t>(frames)};
}

void check_run(Server& server, const CouplerSettings& settings,
               const std::vector<Expected>& expected, const Json& run, const Scene& scene) {
  const Solvers solvers = server.wait_for(expected, run);
  check_surfaces(settings, solvers, scene);
  log_size(settings, solvers);
  server.finish();
  log::info("{}: valid", scene.folder());
}

}  // namespace gabion
