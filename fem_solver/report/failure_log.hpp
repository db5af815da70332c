// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <span>

#include "fem_solver/fem_config.hpp"
#include "fem_solver/interface/changing_surfaces.hpp"
#include "fem_solver/stress/cell_failure.hpp"

namespace gabion::fem {

/// Whether cells or lines of some material may fail.
template <int dim>
bool may_fail(const FemSettings<dim>& settings) {
  const auto fails = [](const auto& material) { return material.failure.any(); };
  return std::ranges::any_of(settings.materials, fails) ||
         std::ranges::any_of(settings.line_materials, fails);
}

/// Log each cell and line of any rank that begins to fail, and warn where the first of them has
/// facets of a wet surface: these facets stay in the surface, on the nodes, without the cell.
/// @param changing  interfaces that facets leave with their cells
/// @param failures  of this rank
/// @param time      of the accepted step [s]
/// @param warned    whether it warned in this run; set
/// @note Collective.
template <int dim>
void log_failures(const FemSettings<dim>& settings, const ChangingSurfaces<dim>& changing,
                  std::span<const Failure> failures, double time, bool& warned);

}  // namespace gabion::fem
