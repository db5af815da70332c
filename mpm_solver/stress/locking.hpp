// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "mpm_solver/points/material_points.hpp"

namespace gabion::mpm {

/// Above this Poisson's ratio the elastic response locks before anything yields.
inline constexpr double locking_poisson_ratio = 0.45;

/// Remedy for volumetric locking, and the reason for it.
struct LockingCure {
  bool average_volumes = false;  ///< F-bar, see AveragedForces
  std::string reason;
};

/// The default: F-bar when a body may yield, whatever its dilation, or is nearly incompressible
/// (locking_poisson_ratio).
template <int dim>
LockingCure default_locking_cure(const std::vector<Body<dim>>& bodies);

}  // namespace gabion::mpm
