// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace gabion::mpm {

/// Least restitution for impact_damping(): smaller ones count as this one.
inline constexpr double least_damped_restitution = 0.01;

/// The damping a of Hunt and Crossley's force k d^n (1 + (a / v_0) dd/dt), with which a mass that
/// meets it at the speed v_0 leaves it at e v_0: a (1 + e) = ln[(1 + a) / (1 - e a)], 0 < e a < 1.
/// The damping depends on neither mass, stiffness, power n nor speed.
/// @param e  in [0, 1]
double impact_damping(double e);

}  // namespace gabion::mpm
