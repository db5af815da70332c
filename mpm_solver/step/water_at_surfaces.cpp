// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step/water_at_surfaces.hpp"

#include <algorithm>
#include <cmath>

namespace gabion::mpm {

template <int dim>
void WaterAtSurfaces<dim>::find(const SoilModel<dim>& model, const MaterialPoints<dim>& points,
                                const PoolLevels& pools, const Vector<dim>& gravity, double dt) {
  const auto& bodies = model.settings.bodies;
  const auto is_wet = [](const Body<dim>& body) { return body.water.has_value(); };
  if (std::ranges::none_of(bodies, is_wet)) return;
  pressures.assign(points.size(), 0);
  grain_stresses.assign(points.size(), Symmetric<dim>::Zero());
  of_bodies.assign(bodies.size(), {});
  for (std::int32_t b = 0; b < points.num_bodies(); ++b) {
    if (!is_wet(bodies[b])) continue;
    const PoreWater& water = *bodies[b].water;
    if (pools.empty()) of_bodies[b].weight = water.density * gravity;
    const double T = water.mobility() * model.moduli[b] * dt / std::pow(model.cell_size, 2);
    of_bodies[b].drained = T / (1 + T);
    for (std::int32_t p = points.body_starts[b]; p < points.body_starts[b + 1]; ++p) {
      const double pore = pore_tau<dim>(bodies[b], points, p);
      pressures[p] = pore / points.J[p] - pools.template pressure<dim>(points.x[p]);
      grain_stresses[p] = points.tau[p];
      grain_stresses[p].template head<3>().array() += pore;
      grain_stresses[p] /= points.J[p];
    }
  }
}

template <int dim>
std::vector<double> pool_pressures_at(const PoolLevels& pools,
                                      const std::vector<Vector<dim>>& places) {
  std::vector<double> pressures;
  if (pools.empty()) return pressures;
  for (const Vector<dim>& x : places) pressures.push_back(pools.template pressure<dim>(x));
  return pressures;
}

template struct WaterAtSurfaces<2>;
template struct WaterAtSurfaces<3>;
template std::vector<double> pool_pressures_at<2>(const PoolLevels&, const std::vector<Vector<2>>&);
template std::vector<double> pool_pressures_at<3>(const PoolLevels&, const std::vector<Vector<3>>&);

}  // namespace gabion::mpm
