// SPDX-License-Identifier: BSD-3-Clause
// Soil on surfaces as the run begins, and whether its initial stress is in balance.
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <string>

#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/checks/soil_at_rest.hpp"
#include "mpm_solver/step/soil_step.hpp"
#include "mpm_solver/stress/point_motion.hpp"

namespace gabion::mpm {

namespace {

// Warn of rows of points deeper than steps search for contact, some three quarters of a cell of the
// grid.
void warn_of_deep_rows(double deepest, double cell_size) {
  constexpr double within = 0.75;
  if (deepest <= within * cell_size) return;
  log::warn(
      "bodies: cells so flat or narrow that points lie {:.3g} m below a side, {:.2g} cells of the "
      "grid: contact with a surface at that side may begin late, and its thrust be too small; "
      "plausible: up to {:g} cells (more points in that direction, or cells like squares)",
      deepest, deepest / cell_size, within);
}

// Largest depth of rows of points free of stress whose spheres do not reach the surface [m].
template <int dim>
double deepest_row_to_reach(const MpmSettings<dim>& settings) {
  double deepest = 0;
  for (std::size_t b = 0; b < settings.layouts.size(); ++b) {
    if (settings.initial_stress[b]) continue;
    deepest = std::max(deepest, deepest_uneven_row(settings.layouts[b]));
  }
  return deepest;
}

// Soil as it lies on the surfaces. Without stress the spheres of rectangular cells alone are set
// off to the surface. Rows of triangles are not symmetric, and where a surface cuts the grid all
// spheres in contact bear less than some of them would. Sand in sheared cells that would be in
// contact with walls and floor at once finds no first balance.
template <int dim>
SoilAtRest<dim> soil_at_rest(const MpmSettings<dim>& settings, const Vector<dim>& gravity,
                             const PoolLevels& pools, const std::vector<std::int64_t>& first_ids) {
  SoilAtRest<dim> rest;
  for (const auto& stress : settings.initial_stress) rest.is_stressed.push_back(stress ? 1 : 0);
  rest.sides = [&](std::int32_t body, std::int64_t id) {
    return laid_sides<dim>(settings.layouts[body], id - first_ids[body],
                           !settings.initial_stress[body]);
  };
  rest.stress = [&settings, gravity, pools](std::int32_t body, const Vector<dim>& x) {
    Vector<dim> stress = initial_stress_at<dim>(
        *settings.initial_stress[body],
        {.body = settings.bodies[body], .number = body, .gravity = gravity}, x[dim - 1]);
    if (!stress.isZero(0)) stress.array() += pools.pressure<dim>(x);  // which pools bear
    return stress;
  };
  return rest;
}

// Undrained soil hardly moves under a load that its skeleton should have borne from the start, so
// its displacement does not show a jump of the stress between bodies.
template <int dim>
void refuse_jump_on_water(const MpmSettings<dim>& settings, const Vector<dim>& gravity,
                          const std::string& where) {
  if (std::ranges::none_of(settings.bodies,
                           [](const Body<dim>& body) { return body.water.has_value(); })) {
    return;
  }
  const std::string text = stress_jump_text<dim>(settings, gravity);
  require<ConfigError>(text.empty(), "{}: the initial stress is not in balance{}", where, text);
}

}  // namespace

// Begin contact with the surfaces at their places at time 0, without forces of stress as yet.
template <int dim>
void SoilStep<dim>::begin_at_rest(const Vector<dim>& gravity, double deepest_row) {
  if (phase().rigid_walls) state_.surfaces.keep_walls(*phase().rigid_walls);
  map_soil();
  if (state_.surfaces.contacts().empty()) return;
  begin_surfaces();
  const PoolLevels pools = pools_at(0);
  state_.surfaces.set_pools(pools);
  state_.surfaces.receive({});
  state_.surfaces.move_walls(0);
  auto rest = soil_at_rest<dim>(model_.settings, gravity, pools, state_.points.body_ids);
  rest.deepest_row = deepest_row;
  state_.surfaces.begin_at_rest(rest);
  state_.ledger.set_contact_energy(state_.surfaces.energy());
}

template <int dim>
void SoilStep<dim>::check_initial_stress() {
  const InitialStress* strictest = nullptr;
  for (const auto& stress : model_.settings.initial_stress) {
    if (stress && (!strictest || stress->max_displacement < strictest->max_displacement)) {
      strictest = &*stress;
    }
  }
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
  begin_at_rest(gravity, std::numeric_limits<double>::infinity());
  begin_surfaces();
  const std::vector<double> du = implicit_->settlement(start_, gravity, strictest->where);
  state_.wall_forces = forces_on_walls(*implicit_, 0);
  state_.rigid_wall_forces = state_.surfaces.forces_on_walls();
  const double largest = max_over_ranks(
      model_.comm,
      largest_displacement(soil_.weights(), soil_.nodes(), std::span<const double>(du)));
  initial_displacement_ = largest;
  log::info("initial stress: would settle by {:.2e} m, {:.2e} of a cell", largest,
            largest / model_.cell_size);
  require<ConfigError>(largest <= strictest->max_displacement * model_.cell_size, [&] {
    return fmt::format(
        "{}: the initial stress is not in balance, a point would move by {:.3g} cells; allowed: "
        "\"max_displacement\" = {:g}{}",
        strictest->where, largest / model_.cell_size, strictest->max_displacement,
        stress_jump_text<dim>(model_.settings, gravity));
  });
}

template void SoilStep<2>::check_initial_stress();
template void SoilStep<3>::check_initial_stress();

}  // namespace gabion::mpm
