// SPDX-License-Identifier: BSD-3-Clause
// Soil on surfaces as the run begins, and whether its initial stress is in balance.
#include <algorithm>
#include <optional>
#include <string>

#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/step/soil_step.hpp"
#include "mpm_solver/step/start_stress.hpp"
#include "mpm_solver/stress/point_motion.hpp"

namespace gabion::mpm {

namespace {

// Largest depth of the rows that points of this rank belong to [m].
template <int dim>
double deepest_row_of(const SoilAtRest<dim>& rest, const PointWeights<dim>& weights,
                      const MaterialPoints<dim>& points) {
  double deepest = 0;
  for (const CellGroup& group : weights.groups) {
    for (std::int32_t e = group.first; e < group.last; ++e) {
      for (const auto& side : rest.sides(group.body, points.id[weights.point[e]])) {
        deepest = std::max(deepest, side.depth);
      }
    }
  }
  return deepest;
}

}  // namespace

// Begin contact with the surfaces at their places at time 0, without forces of stress as yet.
// @param deepest_row  farthest that soil lies from a surface; none: its deepest row [m]
template <int dim>
void SoilStep<dim>::begin_at_rest(const Vector<dim>& gravity, std::optional<double> deepest_row) {
  if (phase().rigid_walls) state_.surfaces.keep_walls(*phase().rigid_walls);
  map_soil();
  if (state_.surfaces.contacts().empty()) return;
  begin_surfaces();
  const PoolLevels pools = pools_at(0);
  state_.surfaces.set_pools(pools);
  state_.surfaces.receive({});
  state_.surfaces.move_walls(0);
  auto rest = soil_at_rest<dim>(model_.settings, gravity, pools, state_.points.body_ids,
                                [this](std::int32_t body, const Vector<dim>& x) {
                                  return implicit_->pressure_of_flow(body, x);
                                });
  rest.deepest_row =
      deepest_row ? *deepest_row : deepest_row_of<dim>(rest, soil_.weights(), state_.points);
  state_.surfaces.begin_at_rest(rest);
  state_.ledger.set_contact_energy(state_.surfaces.energy());
}

template <int dim>
void SoilStep<dim>::check_initial_stress() {
  const InitialStress* strictest = strictest_stress(model_.settings);
  const Vector<dim> gravity = phase().gravity_ramp.at(0) * model_.settings.gravity;
  if (!strictest) {  // soil may move: nothing is looked for along its path
    if (state_.surfaces.contacts().empty()) return;
    const double deepest = deepest_row_to_reach(model_.settings);
    if (deepest == 0) return;
    warn_of_deep_rows(deepest, model_.cell_size);
    start_ = {.dt = 0, .with_inertia = false};
    begin_at_rest(gravity, deepest);
    return;
  }
  start_ = {.dt = 1, .with_inertia = false};
  refuse_jump_on_water(model_.settings, gravity, strictest->where);
  const std::string flow = flow_that_is_asked_for(model_.settings);
  if (!flow.empty()) {
    initial_discharge_ = begin_in_flow<dim>(
        {model_, *implicit_, soil_, start_, pools_at(0), gravity, flow}, state_.points);
  }
  begin_at_rest(gravity, std::nullopt);
  begin_surfaces();
  if (!flow.empty()) {
    implicit_->balance_flow(start_, gravity, flow);
    state_.ledger.start(state_.points);
    state_.ledger.set_contact_energy(state_.surfaces.energy());
    map_soil();
    begin_surfaces();
  }
  const std::vector<double> du = implicit_->settlement(start_, gravity, strictest->where);
  state_.wall_forces = forces_on_walls(*implicit_, 0);
  state_.rigid_wall_forces = state_.surfaces.forces_on_walls();
  initial_displacement_ =
      max_over_ranks(model_.comm, largest_displacement<dim>(soil_.weights(), soil_.nodes(), du));
  require_small_settlement(model_.settings, gravity, {initial_displacement_, model_.cell_size});
}

template void SoilStep<2>::check_initial_stress();
template void SoilStep<3>::check_initial_stress();

}  // namespace gabion::mpm
