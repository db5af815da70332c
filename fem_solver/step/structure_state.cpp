// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/step/structure_state.hpp"

#include <algorithm>
#include <cstdint>

#include "common/base/require.hpp"

namespace gabion::fem {

bool StructureMotion::is_still() const {
  const auto zero = [](double x) { return x == 0; };
  return std::all_of(v.begin(), v.end(), zero) && std::all_of(a.begin(), a.end(), zero);
}

StructureState reference_state(const std::vector<double>& f_ext, CellHistory history) {
  const std::vector<double> zero(f_ext.size(), 0.0);
  StructureState state;
  state.motion = {.u = zero, .v = zero, .a = zero};
  state.f_ext = f_ext;
  state.f_int = state.f_step = state.reactions = zero;
  state.history = std::move(history);
  return state;
}

std::vector<std::pair<std::string, std::vector<double>*>> StructureState::nodal_vectors() {
  std::vector<std::pair<std::string, std::vector<double>*>> vectors = {
      {"u", &motion.u},    {"v", &motion.v},  {"a", &motion.a},         {"f_ext", &f_ext},
      {"f_step", &f_step}, {"f_int", &f_int}, {"reactions", &reactions}};
  if (tangent) vectors.emplace_back("tangent.u", &tangent->u);
  return vectors;
}

void StructureState::visit_state(StateVisitor& visitor, std::vector<std::int64_t>& nodes) {
  visitor.real("time", time);
  visitor.flag("balanced", balanced);
  visitor.real("elastic_energy", elastic_energy);
  visitor.real("external_work", external_work);

  bool has_tangent = tangent.has_value();
  visitor.flag("has_tangent", has_tangent);
  if (!has_tangent) tangent.reset();
  if (has_tangent) {
    if (!tangent) tangent.emplace();
    visitor.real("tangent.dt", tangent->dt);
    visitor.flag("tangent.with_inertia", tangent->with_inertia);
  }

  std::int64_t method = rescue ? static_cast<std::int64_t>(*rescue) : -1;
  visitor.integer("rescue", method);
  require(method >= -1 && method <= static_cast<std::int64_t>(SolutionMethod::cg),
          "saved state: \"rescue\" is no method of solution");
  pause.visit_state(visitor);
  rescue.reset();
  if (method >= 0) rescue = static_cast<SolutionMethod>(method);

  visitor.list("nodes", nodes);
  for (const auto& [name, values] : nodal_vectors()) visitor.list(name, *values);
}

void StructureState::visit_damping(StateVisitor& visitor) {
  visitor.real("damping_work", damping_work);
}

void StructureState::visit_failure(StateVisitor& visitor) {
  visitor.real("failed_energy", failed_energy);
}

void StructureState::visit_damage(StateVisitor& visitor) {
  visitor.real("damage_work", damage_work);
  visitor.real("widest_crack.width", widest_crack.width);
  visitor.real("widest_crack.time", widest_crack.time);
  visitor.real("widest_crack.x", widest_crack.place[0]);
  visitor.real("widest_crack.y", widest_crack.place[1]);
  visitor.real("widest_crack.z", widest_crack.place[2]);
}

void StructureState::visit_history(StateVisitor& visitor, HistoryRows& rows) {
  visitor.real("plastic_work", plastic_work);
  visitor.real("brake_work", brake_work);
  visitor.integer("history_width", rows.width);
  visitor.list("cells", rows.cells);
  visitor.list("history", rows.values);
}

}  // namespace gabion::fem
