// SPDX-License-Identifier: BSD-3-Clause
// What of the soil later steps depend on.
#include <fmt/format.h>

#include <algorithm>

#include "common/base/require.hpp"
#include "common/mechanics/flat.hpp"
#include "mpm_solver/mpm_solver.hpp"

namespace gabion::mpm {

namespace {

void require_below(const char* what, std::int32_t first, std::span<const std::int32_t> indices,
                   std::int32_t end) {
  for (const std::int32_t index : indices) {
    require(index >= first && index < end, "saved state: {}: found {}, allowed: {} to {}", what,
            index, first, end - 1);
  }
}

template <int dim>
void visit_history(StateVisitor& visitor, std::vector<MaterialState<dim>>& history) {
  std::vector<Symmetric<dim>> e;
  std::vector<double> plastic_strain, gap;
  for (const MaterialState<dim>& state : history) {
    e.push_back(state.e);
    plastic_strain.push_back(state.plastic_strain);
    gap.push_back(state.gap);
  }
  visitor.reals("points.history.e", flat(e));
  visitor.reals("points.history.plastic_strain", plastic_strain);
  visitor.reals("points.history.gap", gap);
  for (std::size_t p = 0; p < history.size(); ++p) history[p] = {e[p], plastic_strain[p], gap[p]};
}

// The points themselves (mass, V0, body) follow from the settings, but those that have left the
// grid are gone.
template <int dim>
void visit_points(StateVisitor& visitor, MaterialPoints<dim>& points) {
  std::vector<std::int64_t> id = points.id;
  visitor.list("points.id", id);
  std::vector<std::int32_t> gone;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    if (!std::binary_search(id.begin(), id.end(), points.id[p])) gone.push_back(p);
  }
  if (!gone.empty()) remove_points<dim>(gone, points);
  require(id == points.id, "saved state: its material points are those of other ranks or bodies");
  visitor.reals("points.x", flat(points.x));
  visitor.reals("points.u", flat(points.u));
  visitor.reals("points.v", flat(points.v));
  visitor.reals("points.a", flat(points.a));
  visitor.reals("points.grad_v", flat(points.grad_v));
  visitor.reals("points.grad_a", flat(points.grad_a));
  visitor.reals("points.J", points.J);
  visitor.reals("points.energy", points.energy);
  visitor.reals("points.tau", flat(points.tau));
  visit_history(visitor, points.history);
  visitor.integers("points.cell", points.cell);
  visitor.reals("points.F", flat(points.F));
}

}  // namespace

template <int dim>
void MpmSolver<dim>::visit_state(StateVisitor& visitor) {
  visit_points(visitor, points_);
  for (std::size_t k = 0; k < boundaries_.size(); ++k) {
    boundaries_[k].visit_state(visitor, fmt::format("boundary_{}.", k));
  }
  ledger_.visit_state(visitor);
  visitor.reals("wall_forces", flat(wall_forces_));
  visitor.reals("rigid_wall_forces", rigid_wall_forces_);
  visitor.integers("probe_points", std::span<std::int32_t>(probe_points_));
  visitor.integer("removed_points", removed_points_);
  control_.visit_state(visitor);
}

template <int dim>
State MpmSolver<dim>::save_state() {
  State state;
  StateWriter writer(state);
  visit_state(writer);
  return state;
}

template <int dim>
void MpmSolver<dim>::load_state(const State& state) {
  dt_ = 0;
  StateReader reader(state);
  visit_state(reader);
  require_below("cell of a material point", 0, points_.cell, grid_.mesh.num_cells());
  require_below("material point of a probe", -1, probe_points_, points_.size());
}

template void MpmSolver<2>::visit_state(StateVisitor& visitor);
template void MpmSolver<3>::visit_state(StateVisitor& visitor);
template State MpmSolver<2>::save_state();
template State MpmSolver<3>::save_state();
template void MpmSolver<2>::load_state(const State& state);
template void MpmSolver<3>::load_state(const State& state);

}  // namespace gabion::mpm
