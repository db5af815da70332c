// SPDX-License-Identifier: BSD-3-Clause
// Pressure on surfaces of the water in the soil, and over it.
#include "mpm_solver/checks/pools.hpp"
#include "mpm_solver/step/soil_step.hpp"
#include "mpm_solver/step/water_at_surfaces.hpp"

namespace gabion::mpm {

template <int dim>
PoolLevels SoilStep<dim>::pools_at(double time) const {
  return pool_levels<dim>(model_.settings, time,
                          phase().gravity_ramp.at(time) * model_.settings.gravity);
}

// The pressures of pools that the stresses of the points have.
template <int dim>
std::vector<double> SoilStep<dim>::pool_pressures() const {
  return pool_pressures_at<dim>(pools_at(start_.time), state_.points.x);
}

template <int dim>
void SoilStep<dim>::find_pore_pressures() {
  const Vector<dim> gravity = phase().gravity_ramp.at(start_.time) * model_.settings.gravity;
  WaterAtSurfaces<dim>{pore_pressures_, grain_stresses_, pore_waters_}.find(
      model_, state_.points, pools_at(start_.time), gravity, start_.dt);
}

template PoolLevels SoilStep<2>::pools_at(double) const;
template std::vector<double> SoilStep<2>::pool_pressures() const;
template void SoilStep<2>::find_pore_pressures();
template PoolLevels SoilStep<3>::pools_at(double) const;
template std::vector<double> SoilStep<3>::pool_pressures() const;
template void SoilStep<3>::find_pore_pressures();

}  // namespace gabion::mpm
