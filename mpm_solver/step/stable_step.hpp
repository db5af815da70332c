// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "mpm_solver/step/soil_model.hpp"

namespace gabion::mpm {

/// Largest stable substep of an explicit step. Central differences need dt <= 2 / omega for the
/// highest frequency omega; a contact whose force is constant in a substep needs dt <= sqrt(2) /
/// omega_c. Together
///
///     dt^2 (1 / dt_0^2 + rate_c / 2) <= 1 ,  dt_0 = min_p h_eff / c ,
///     h_eff = 2 / sqrt(n lambda_max(sum_i g_i (x) g_i)) ,  g_i = grad N_i in the middle of the
///     cell
///
/// h_eff / c is 2 / omega of a cell of n nodes of equal mass, and no grid of such cells has a
/// higher frequency; for a rectangle h_eff is its shorter side. rate_c bounds omega_c^2. c is the
/// elastic wave speed; of Cam-Clay, which stiffens with its pressure, that of its stiffest point.
/// A viscous fluid shortens its dt_0 by the damping ratio xi of the highest frequency,
///
///     dt_0 = h_eff / c (sqrt(1 + xi^2) - xi) ,  xi = 4 mu / (3 rho c h_eff)
///
/// so that a thick one has dt_0 = 3 rho h_eff^2 / (8 mu), whatever its speed of sound.
/// @see Irons and Treharne (1971)
template <int dim>
class StableStep {
 public:
  explicit StableStep(const SoilModel<dim>& model);

  /// dt_0 of this state [s]. @note Collective.
  double of_soil(const MaterialPoints<dim>& points) const;

 private:
  double wave_speed(const MaterialPoints<dim>& points, std::int32_t body) const;
  double share_by_viscosity(std::int32_t body, double size) const;

  const SoilModel<dim>& model_;
  std::vector<double> size_;  // h_eff of each cell, of a box of all cells [m]
};

/// Square of a substep's length over that of the longest stable one.
inline double squared_courant(double dt, double soil_dt, double contact_rate) {
  return dt * dt * (1 / (soil_dt * soil_dt) + contact_rate / 2);
}

/// h_eff of a cell [m].
template <int dim>
double effective_size(const BackgroundGrid<dim>& grid, std::int32_t cell);

}  // namespace gabion::mpm
