// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step/start_stress.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "mpm_solver/checks/soil_at_rest.hpp"
#include "mpm_solver/points/laid_sides.hpp"

namespace gabion::mpm {

namespace {

// Pressure of pools on the surface of a body, above a place [Pa].
template <int dim>
double pool_on_surface(const InitialStress& stress, const PoolLevels& pools, Vector<dim> x) {
  x[dim - 1] = stress.surface;
  return pools.pressure<dim>(x);
}

}  // namespace

template <int dim>
SoilAtRest<dim> soil_at_rest(
    const MpmSettings<dim>& settings, const Vector<dim>& gravity, const PoolLevels& pools,
    const std::vector<std::int64_t>& first_ids,
    const std::function<double(std::int32_t body, const Vector<dim>& x)>& pressure) {
  SoilAtRest<dim> rest;
  for (const auto& stress : settings.initial_stress) rest.is_stressed.push_back(stress ? 1 : 0);
  rest.sides = [&](std::int32_t body, std::int64_t id) {
    return laid_sides<dim>(settings.layouts[body], id - first_ids[body],
                           !settings.initial_stress[body]);
  };
  rest.stress = [&settings, gravity, pools, pressure](std::int32_t body, const Vector<dim>& x) {
    const InitialStress& at_start = *settings.initial_stress[body];
    FlowingWater flow;
    if (at_start.steady_seepage) {
      flow = {pressure(body, x), pool_on_surface<dim>(at_start, pools, x)};
    }
    Vector<dim> stress = initial_stress_at<dim>(
        at_start, {.body = settings.bodies[body], .number = body, .gravity = gravity}, x[dim - 1],
        at_start.steady_seepage ? &flow : nullptr);
    if (!stress.isZero(0)) stress.array() += pools.pressure<dim>(x);  // which pools bear
    return stress;
  };
  return rest;
}

namespace {

template <int dim>
void set_stress_in_flow(const StartInFlow<dim>& parts, std::span<const double> pressures,
                        MaterialPoints<dim>& points) {
  const MpmSettings<dim>& settings = parts.model.settings;
  std::vector<FlowingWater> water(points.size());
  for (std::size_t b = 0; b < settings.bodies.size(); ++b) {
    if (!settings.initial_stress[b] || !settings.initial_stress[b]->steady_seepage) continue;
    const InitialStress& stress = *settings.initial_stress[b];
    for (std::int32_t p = points.body_starts[b]; p < points.body_starts[b + 1]; ++p) {
      water[p] = {pressures[p], pool_on_surface<dim>(stress, parts.pools, points.x[p])};
    }
    set_initial_stress<dim>(parts.model.comm, stress,
                            {.body = settings.bodies[b],
                             .number = static_cast<std::int32_t>(b),
                             .gravity = parts.gravity,
                             .laws = parts.soil.laws().of_points()},
                            points, water);
  }
}

}  // namespace

template <int dim>
double begin_in_flow(const StartInFlow<dim>& parts, MaterialPoints<dim>& points) {
  // The permeability may follow the volume of the pores, which the stress changes.
  const bool follows = std::ranges::any_of(parts.model.settings.bodies, [](const Body<dim>& body) {
    return body.water && body.water->kozeny_carman;
  });
  double discharge = 0;
  for (int pass = 0; pass < (follows ? 2 : 1); ++pass) {
    parts.soil.map({.phase = parts.start.phase,
                    .dt = parts.start.dt,
                    .with_inertia = parts.start.with_inertia});
    const SteadyFlow flow = parts.step.find_steady_flow(parts.start, parts.gravity, parts.where);
    discharge = flow.discharge;
    set_stress_in_flow<dim>(parts, flow.pressures, points);
  }
  log::info("steady seepage: {:.4g} m^3/s{} pass the soil at the start", discharge,
            dim == 2 ? " per metre of thickness" : "");
  return discharge;
}

void warn_of_deep_rows(double deepest, double cell_size) {
  constexpr double within = 0.75;
  if (deepest <= within * cell_size) return;
  log::warn(
      "bodies: cells so flat or narrow that points lie {:.3g} m below a face, {:.2g} cells of the "
      "grid: contact with a surface at that face may begin late, and the thrust may be too small; "
      "plausible: up to {:g} cells (more points in that direction, or square cells)",
      deepest, deepest / cell_size, within);
}

template <int dim>
double deepest_row_to_reach(const MpmSettings<dim>& settings) {
  double deepest = 0;
  for (std::size_t b = 0; b < settings.layouts.size(); ++b) {
    if (settings.initial_stress[b]) continue;
    deepest = std::max(deepest, deepest_uneven_row(settings.layouts[b]));
  }
  return deepest;
}

template <int dim>
const InitialStress* strictest_stress(const MpmSettings<dim>& settings) {
  const InitialStress* strictest = nullptr;
  for (const auto& stress : settings.initial_stress) {
    if (stress && (!strictest || stress->max_displacement < strictest->max_displacement)) {
      strictest = &*stress;
    }
  }
  return strictest;
}

template <int dim>
std::string flow_that_is_asked_for(const MpmSettings<dim>& settings) {
  for (const auto& stress : settings.initial_stress) {
    if (stress && stress->steady_seepage) return stress->where_pressure;
  }
  return "";
}

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

template <int dim>
void require_small_settlement(const MpmSettings<dim>& settings, const Vector<dim>& gravity,
                              const InitialSettlement& found) {
  const double largest = found.largest, cell_size = found.cell_size;
  const InitialStress& strictest = *strictest_stress(settings);
  log::info("initial stress: the soil would settle by {:.2e} m, {:.2e} of a cell", largest,
            largest / cell_size);
  require<ConfigError>(largest <= strictest.max_displacement * cell_size, [&] {
    return fmt::format(
        "{}: the initial stress is not in balance, a point would move by {:.3g} cells; allowed: "
        "\"max_displacement\" = {:g}{}",
        strictest.where, largest / cell_size, strictest.max_displacement,
        stress_jump_text<dim>(settings, gravity));
  });
}

template SoilAtRest<2> soil_at_rest<2>(
    const MpmSettings<2>&, const Vector<2>&, const PoolLevels&, const std::vector<std::int64_t>&,
    const std::function<double(std::int32_t, const Vector<2>&)>&);
template SoilAtRest<3> soil_at_rest<3>(
    const MpmSettings<3>&, const Vector<3>&, const PoolLevels&, const std::vector<std::int64_t>&,
    const std::function<double(std::int32_t, const Vector<3>&)>&);
template double begin_in_flow<2>(const StartInFlow<2>&, MaterialPoints<2>&);
template double begin_in_flow<3>(const StartInFlow<3>&, MaterialPoints<3>&);
template void require_small_settlement<2>(const MpmSettings<2>&, const Vector<2>&,
                                          const InitialSettlement&);
template void require_small_settlement<3>(const MpmSettings<3>&, const Vector<3>&,
                                          const InitialSettlement&);
template double deepest_row_to_reach<2>(const MpmSettings<2>&);
template double deepest_row_to_reach<3>(const MpmSettings<3>&);
template const InitialStress* strictest_stress<2>(const MpmSettings<2>&);
template const InitialStress* strictest_stress<3>(const MpmSettings<3>&);
template std::string flow_that_is_asked_for<2>(const MpmSettings<2>&);
template std::string flow_that_is_asked_for<3>(const MpmSettings<3>&);
template void refuse_jump_on_water<2>(const MpmSettings<2>&, const Vector<2>&, const std::string&);
template void refuse_jump_on_water<3>(const MpmSettings<3>&, const Vector<3>&, const std::string&);

}  // namespace gabion::mpm
