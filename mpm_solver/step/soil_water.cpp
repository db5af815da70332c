// SPDX-License-Identifier: BSD-3-Clause
// Pressure on surfaces of the water in the soil, and over it.
#include <algorithm>
#include <limits>

#include "mpm_solver/checks/pools.hpp"
#include "mpm_solver/checks/seepage.hpp"
#include "mpm_solver/step/soil_step.hpp"

namespace gabion::mpm {

template <int dim>
PoolLevels SoilStep<dim>::pools_at(double time) const {
  return pool_levels<dim>(model_.settings, time,
                          phase().gravity_ramp.at(time) * model_.settings.gravity);
}

// Specific weight of water that drains, one for all bodies. Under pools pressures are those beyond
// the pools', which do not change along the normal of a surface.
template <int dim>
Vector<dim> SoilStep<dim>::water_weight() const {
  const auto& bodies = model_.settings.bodies;
  if (!model_.settings.pools.empty()) return Vector<dim>::Zero();
  const auto body = std::ranges::find_if(bodies, drains<dim>);
  if (body == bodies.end()) return Vector<dim>::Zero();
  const double share = phase().gravity_ramp.at(start_.time);
  return share * body->water->density * model_.settings.gravity;
}

// Pressures at the points. Points whose water does not drain have none at a surface: minus
// infinity, so that no weight of water raises it above 0 there.
template <int dim>
void SoilStep<dim>::find_pore_pressures() {
  const MaterialPoints<dim>& points = state_.points;
  pore_pressures_.assign(points.size(), -std::numeric_limits<double>::infinity());
  const PoolLevels pools = pools_at(start_.time);
  for (std::int32_t b = 0; b < points.num_bodies(); ++b) {
    const Body<dim>& body = model_.settings.bodies[b];
    if (!drains(body)) continue;
    for (std::int32_t p = points.body_starts[b]; p < points.body_starts[b + 1]; ++p) {
      pore_pressures_[p] = body.water->at(points.water[p], points.J[p]).p -
                           pools.template pressure<dim>(points.x[p]);
    }
  }
}

template PoolLevels SoilStep<2>::pools_at(double) const;
template Vector<2> SoilStep<2>::water_weight() const;
template void SoilStep<2>::find_pore_pressures();
template PoolLevels SoilStep<3>::pools_at(double) const;
template Vector<3> SoilStep<3>::water_weight() const;
template void SoilStep<3>::find_pore_pressures();

}  // namespace gabion::mpm
