// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "mpm_solver/contact/soil_surface.hpp"
#include "mpm_solver/points/pool.hpp"
#include "mpm_solver/step/soil_model.hpp"

namespace gabion::mpm {

/// Pore water where contact begins, as SoilSurface has it; left empty where no body has any.
template <int dim>
struct WaterAtSurfaces {
  std::vector<double>& pressures;               ///< of the points, beyond those of pools [Pa]
  std::vector<Symmetric<dim>>& grain_stresses;  ///< of the points [Pa]
  std::vector<WaterOfBody<dim>>& of_bodies;

  /// @param dt  of the step [s]
  void find(const SoilModel<dim>& model, const MaterialPoints<dim>& points, const PoolLevels& pools,
            const Vector<dim>& gravity, double dt);
};

/// Pressures of pools at places [Pa]; empty without pools.
template <int dim>
std::vector<double> pool_pressures_at(const PoolLevels& pools,
                                      const std::vector<Vector<dim>>& places);

}  // namespace gabion::mpm
