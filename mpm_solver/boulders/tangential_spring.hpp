// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "mpm_solver/boulders/hard_contact.hpp"

namespace gabion::mpm {

/// Stiffness of the tangential direction: that of the normal one at this gap, and no less than the
/// least one. With the least one alone the friction of an impact would be the smaller, the faster
/// and the stiffer the bodies are [N/m].
inline double tangential_at(double gap, double least, const HardLaw& law) {
  return std::max(least, -2 * law.stiffness * gap);
}

/// Share of its length that a spring keeps as its stiffness changes: a stiffer one keeps its force,
/// a softer one its length, so that neither stores more than before.
inline double length_kept(double stiffness_before, double stiffness) {
  return std::min(1.0, stiffness_before / stiffness);
}

/// A spring that slips at a limit: it dissipates energy or keeps it.
inline Vector<3> spring(const Vector<3>& stretched, double stiffness, double limit) {
  const double size = stiffness * stretched.norm();
  return size <= limit ? stretched : Vector<3>(stretched * (limit / size));
}

}  // namespace gabion::mpm
