// SPDX-License-Identifier: BSD-3-Clause
// Pressure on surfaces of the water in the soil, and over it.
#include <algorithm>
#include <limits>

#include "mpm_solver/checks/pools.hpp"
#include "mpm_solver/step/soil_step.hpp"

namespace gabion::mpm {

template <int dim>
PoolLevels SoilStep<dim>::pools_at(double time) const {
  return pool_levels<dim>(model_.settings, time,
                          phase().gravity_ramp.at(time) * model_.settings.gravity);
}

// What the water at points bears where contact begins. Soil without water has none to carry on to a
// surface: minus infinity. Under pools pressures are those beyond the pools', which do not change
// along the normal of a surface.
template <int dim>
void SoilStep<dim>::find_pore_pressures() {
  const auto& bodies = model_.settings.bodies;
  const auto is_wet = [](const Body<dim>& body) { return body.water.has_value(); };
  if (std::ranges::none_of(bodies, is_wet)) return;
  const MaterialPoints<dim>& points = state_.points;
  pore_pressures_.assign(points.size(), -std::numeric_limits<double>::infinity());
  water_weights_.assign(bodies.size(), Vector<dim>::Zero());
  const PoolLevels pools = pools_at(start_.time);
  const Vector<dim> g = phase().gravity_ramp.at(start_.time) * model_.settings.gravity;
  for (std::int32_t b = 0; b < points.num_bodies(); ++b) {
    if (!is_wet(bodies[b])) continue;
    const PoreWater& water = *bodies[b].water;
    if (model_.settings.pools.empty()) water_weights_[b] = water.density * g;
    for (std::int32_t p = points.body_starts[b]; p < points.body_starts[b + 1]; ++p) {
      pore_pressures_[p] =
          water.at(points.water[p], points.J[p]).p - pools.template pressure<dim>(points.x[p]);
    }
  }
}

template PoolLevels SoilStep<2>::pools_at(double) const;
template void SoilStep<2>::find_pore_pressures();
template PoolLevels SoilStep<3>::pools_at(double) const;
template void SoilStep<3>::find_pore_pressures();

}  // namespace gabion::mpm
