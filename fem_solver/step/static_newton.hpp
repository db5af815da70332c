// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <limits>

#include "fem_solver/fem_config.hpp"

namespace gabion::fem {

/// Whether lines of the structure, such as cables and brakes, or membranes may go slack.
template <int dim>
bool may_slacken(const FemSettings<dim>& s) {
  return std::ranges::any_of(s.line_materials,
                             [](const LineMaterial& line) { return !line.in_compression; }) ||
         std::ranges::any_of(s.membranes, &MembraneMaterial::tension_only);
}

/// Whether something has no stiffness across without a force: membranes, lines beside beams.
template <int dim>
bool may_be_loose(const FemSettings<dim>& s) {
  return !s.membranes.empty() ||
         std::ranges::any_of(s.line_materials, [](const LineMaterial& line) { return !line.beam; });
}

/// Iterations without inertia of structures whose lines or membranes may go slack, over those of
/// others: under weight alone slack lines have no stiffness, and each step of Newton's method is a
/// short one.
inline constexpr int slack_iterations = 50;

/// Newton's method without inertia: that of the settings, with more iterations for slack lines.
template <int dim>
NewtonSettings static_newton(const FemSettings<dim>& settings) {
  NewtonSettings newton = settings.newton;
  if (may_slacken(settings)) {
    constexpr int most = std::numeric_limits<int>::max() / slack_iterations;
    newton.max_iterations = slack_iterations * std::min(newton.max_iterations, most);
  }
  return newton;
}

}  // namespace gabion::fem
