// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/step/sides.hpp"

#include <algorithm>
#include <exception>
#include <utility>

#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "common/settings/scene.hpp"
#include "coupler/state_vectors.hpp"
#include "coupler/step/start.hpp"

namespace gabion {

namespace {

Solver& find_solver(const std::vector<NamedSolver>& participants, const std::string& name) {
  const auto found = std::find_if(participants.begin(), participants.end(),
                                  [&](const NamedSolver& p) { return p.name == name; });
  require<ConfigError>(found != participants.end(), "participant \"{}\" of coupler.json is missing",
                       name);
  return found->solver;
}

template <class Value>
std::string bytes_of(const std::vector<Value>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Value)};
}

/// Participant -> kinds of the forces on its interfaces, where any is a mean force.
std::map<std::string, ForceKinds> kinds_of_forces(
    const std::vector<InterfaceSettings>& interfaces,
    const std::map<std::string, std::vector<InterfaceMesh>>& meshes) {
  std::map<std::string, ForceKinds> kinds;
  for (const InterfaceSettings& interface : interfaces) {
    for (const InterfaceMesh& mesh : meshes.at(interface.soil)) {
      if (mesh.name != interface.name || mesh.force_kind == ForceKind::end_of_step) continue;
      kinds[interface.soil][mesh.name] = mesh.force_kind;
      kinds[interface.structure][mesh.name] = mesh.force_kind;
    }
  }
  return kinds;
}

void set_start_weights(const Side& side, const std::map<std::string, ForceKinds>& all,
                       Eigen::VectorXd& weights) {
  const auto kinds = all.find(side.name());
  if (kinds == all.end()) return;
  for (const auto& [interface, kind] : kinds->second) {
    side.layout().fill(interface, kind == ForceKind::step_mean ? 0 : 0.5, weights);
  }
}

}  // namespace

Sides::Sides(const CouplerSettings& settings, const std::vector<NamedSolver>& participants,
             PhaseTimes& phases)
    : phases_(phases) {
  std::map<std::string, std::vector<InterfaceMesh>> meshes;
  for (const ParticipantRole& role : settings.participants) {
    meshes[role.name] = find_solver(participants, role.name).interfaces();
    for (const InterfaceMesh& mesh : meshes[role.name]) {
      surfaces_[role.name][mesh.name] =
          hash_text(bytes_of(mesh.coordinates) + bytes_of(mesh.facets));
    }
  }
  map_ = std::make_unique<InterfaceMap>(settings.interfaces, meshes, settings.coupling.mapping);
  force_kinds_ = kinds_of_forces(settings.interfaces, meshes);
  for (const ParticipantRole& role : settings.participants) {
    (role.sends_force ? soils_ : structures_)
        .emplace_back(map_->layout(role.name), find_solver(participants, role.name));
  }
  accepted_x_ = Eigen::VectorXd::Zero(map_->size());
  for (const Side& structure : structures_) {
    for (auto& [name, facets] : changing_facets(structure.solver())) {
      facets_[name] = std::move(facets);
    }
  }
  check_changing(settings.interfaces);
}

/// @throws ConfigError  facets may change that the soil of the interface cannot take
void Sides::check_changing(const std::vector<InterfaceSettings>& interfaces) const {
  for (const InterfaceSettings& interface : interfaces) {
    if (!facets_.contains(interface.name)) continue;
    const auto soil = std::ranges::find_if(
        soils_, [&](const Side& side) { return side.name() == interface.soil; });
    require<ConfigError>(
        takes_facets(soil->solver()),
        "interface \"{}\": facets of \"{}\" may leave it, and \"{}\" cannot take other facets, "
        "allowed: a soil with contact by facets and without boulders",
        interface.name, interface.structure, interface.soil);
    require<ConfigError>(
        map_->has_same_vertices(interface.name),
        "interface \"{}\": facets of \"{}\" may leave it, and \"{}\" has other vertices, allowed: "
        "the same ones: \"surface\" of mpm.json with the mesh, \"groups\" and \"behind\" of the "
        "interface in fem.json",
        interface.name, interface.structure, interface.soil);
    map_->require_same_facets(interface.name);
  }
}

bool Sides::take_facets() {
  for (const Side& structure : structures_) {
    for (auto& [name, facets] : changing_facets(structure.solver())) {
      if (facets_[name] == facets) continue;
      changed_[name] = facets_[name] = std::move(facets);
    }
  }
  return !changed_.empty();
}

void Sides::tell_facets() {
  for (const Side& soil : soils_) {
    InterfaceFacets own;
    for (const InterfaceMesh& mesh : soil.solver().interfaces()) {
      const auto found = changed_.find(mesh.name);
      if (found != changed_.end()) own.insert(*found);
    }
    if (!own.empty()) set_facets(soil.solver(), own);
  }
  changed_.clear();
}

void Sides::tell_force_kinds() {
  for (const Side& structure : structures_) {
    const auto kinds = force_kinds_.find(structure.name());
    if (kinds == force_kinds_.end()) continue;
    if (structure.solver().takes_force_kinds()) {
      structure.solver().set_force_kinds(kinds->second);
      continue;
    }
    log::warn(
        "participant \"{}\" takes the soil's mean forces of a step as those of its end: they act "
        "half a step late, and energy is created where contact opens (protocol/README.md, section "
        "3)",
        structure.name());
  }
}

void Sides::tell_start() {
  for (const Side& structure : structures_) {
    put_start(structure.solver(), structure.layout(), accepted_x_);
  }
  if (accepted_x_.isZero(0)) return;
  const Eigen::VectorXd u = map_->soil_displacement(accepted_x_);
  for (const Side& soil : soils_) gabion::tell_start(soil.solver(), soil.layout(), u);
}

Eigen::VectorXd Sides::soil_start_weights() const {
  Eigen::VectorXd weights = Eigen::VectorXd::Constant(map_->soil_size(), 0.5);
  for (const Side& soil : soils_) set_start_weights(soil, force_kinds_, weights);
  return weights;
}

Eigen::VectorXd Sides::structure_start_weights() const {
  Eigen::VectorXd weights = Eigen::VectorXd::Constant(map_->size(), 0.5);
  for (const Side& structure : structures_) {
    if (!structure.solver().takes_force_kinds()) continue;
    set_start_weights(structure, force_kinds_, weights);
  }
  return weights;
}

std::vector<Side*> Sides::all() {
  std::vector<Side*> all;
  for (Side& soil : soils_) all.push_back(&soil);
  for (Side& structure : structures_) all.push_back(&structure);
  return all;
}

std::vector<StepReport> Sides::soil_reports() const {
  std::vector<StepReport> reports;
  for (const Side& soil : soils_) reports.push_back(soil.report());
  return reports;
}

bool Sides::all_structures_solved() const {
  return std::all_of(structures_.begin(), structures_.end(),
                     [](const Side& structure) { return structure.solved(); });
}

bool Sides::contact_possible(const Attempt& now) const {
  const bool active = std::any_of(soils_.begin(), soils_.end(),
                                  [](const Side& soil) { return soil.report().interface_active; });
  require(active || now.f.isZero(0),
          "step {}: the soil sends a force (largest component {} N) and says that its "
          "interfaces are not active",
          now.request.step, now.f.cwiseAbs().maxCoeff());
  return active;
}

void Sides::begin_step() {
  for (Side* side : all()) side->begin_step();
}

void Sides::begin_solution() {
  for (Side* side : all()) side->begin_solution();
}

void Sides::start_soils(Attempt& now) {
  if (std::exchange(now.soils_asked, false)) return;
  now.u = map_->soil_displacement(now.x);
  for (Side& soil : soils_) soil.start_solve(now.request, now.u);
}

void Sides::start_structures(Attempt& now, bool may_sleep) {
  for (Side& structure : structures_) {
    if (may_sleep && structure.may_sleep()) {
      structure.skip();
    } else {
      structure.start_solve(now.request, now.f_given);
    }
  }
}

/// @returns the Newton iterations of all these solutions
int Sides::finish_all(std::vector<Side>& sides, Eigen::VectorXd& answer) {
  int newton_iterations = 0;
  std::exception_ptr failure;
  for (Side& side : sides) {
    if (!side.is_under_way()) continue;
    try {
      const ScopedTimer timer(phases_, side.name());
      side.finish_solve(answer);
      newton_iterations += side.report().newton_iterations;
    } catch (const ConvergenceError&) {
      if (!failure) failure = std::current_exception();
    }
  }
  if (failure) std::rethrow_exception(failure);
  return newton_iterations;
}

void Sides::finish_soils(Attempt& now, const Stopwatch& since) {
  now.f_soil = Eigen::VectorXd::Zero(map_->soil_size());
  now.row.soil_newton = finish_all(soils_, now.f_soil);
  now.soil_newton += now.row.soil_newton;
  now.f = map_->structure_force(now.f_soil);
  now.row.soil = map_->soil_resultant(now.u, now.f_soil);
  now.row.structure = map_->structure_resultant(now.x, now.f);
  now.row.soil_seconds = since.seconds();
}

void Sides::finish_structures(Attempt& now, const Stopwatch& since) {
  now.x_tilde = accepted_x_;  // the value for structures that are not solved
  now.row.structure_newton = finish_all(structures_, now.x_tilde);
  now.structure_newton += now.row.structure_newton;
  now.row.structure_seconds = since.seconds();
}

void Sides::solve_soils(Attempt& now) {
  const Stopwatch watch;
  start_soils(now);
  finish_soils(now, watch);
}

void Sides::solve_structures(Attempt& now, bool may_sleep) {
  const Stopwatch watch;
  start_structures(now, may_sleep);
  finish_structures(now, watch);
}

void Sides::start_accept(const Attempt& now) {
  accepted_x_ = now.x_tilde;
  for (Side* side : all()) side->start_accept(now.request);
}

AcceptReport Sides::finish_structures_accept(const Attempt& now, const Stopwatch& since) {
  return finish_accept(structures_, now.f_given, since);
}

AcceptReport Sides::finish_soils_accept(const Attempt& now, const Stopwatch& since) {
  return finish_accept(soils_, now.u, since);
}

AcceptReport Sides::finish_accept(std::vector<Side>& sides, const Eigen::VectorXd& given,
                                  Stopwatch since) {
  const ScopedTimer timer(phases_, "accept");
  AcceptReport all;
  for (Side& side : sides) {
    const AcceptReport report = side.finish_accept(given, since);
    since = Stopwatch();  // no wait counts twice
    all.probes.insert(all.probes.end(), report.probes.begin(), report.probes.end());
    all.proposed_dt = smaller_dt(all.proposed_dt, report.proposed_dt);
  }
  return all;
}

bool Sides::take_next_step() const {
  return std::all_of(soils_.begin(), soils_.end(),
                     [](const Side& soil) { return soil.takes_next_step(); });
}

void Sides::start_next(Attempt& now, const DtRange& proposed) {
  now.u = map_->soil_displacement(now.x);
  for (Side& soil : soils_) soil.start_next(now.request, now.u, proposed);
  now.soils_asked = true;
}

bool Sides::solve_next() const {
  return std::all_of(soils_.begin(), soils_.end(),
                     [](const Side& soil) { return soil.solves_next(); });
}

void Sides::call_off_next() {
  for (Side& soil : soils_) soil.call_off_next();
}

void Sides::reject() {
  for (Side* side : all()) side->reject();
}

/// Save the surfaces, or compare them: a foreign code does not read the scene, so its surface may
/// have changed.
void Sides::visit_surfaces(StateVisitor& visitor) const {
  Json saved = surfaces_;
  visitor.fact("surfaces", saved);
  for (const auto& participant : surfaces_.items()) {
    const Json before = saved.value(participant.key(), Json::object());
    for (const auto& surface : participant.value().items()) {
      require<ConfigError>(
          before.value(surface.key(), Json()) == surface.value(),
          "participant \"{}\": found another mesh of interface \"{}\", allowed: that of the run "
          "that is continued, to the last digit (another build of its program may compute others)",
          participant.key(), surface.key());
    }
  }
}

void Sides::visit_state(StateVisitor& visitor) {
  visit_surfaces(visitor);
  map_->visit_state(visitor);
  visit_vector(visitor, "accepted_x", accepted_x_);
  for (auto& [name, facets] : facets_) {
    Json saved = facets;
    visitor.fact("facets." + name, saved);
    facets = saved.get<std::vector<std::int64_t>>();
  }
  for (Side* side : all()) side->visit_state(visitor);
}

}  // namespace gabion
