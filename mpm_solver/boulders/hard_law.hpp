// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "mpm_solver/boulders/hard_contact.hpp"

namespace gabion::mpm {

/// Law of the contact of two bodies, or of a body and an obstacle, whose numbers follow those of
/// the bodies.
inline HardLaw law_between(const std::vector<HardBody>& bodies, std::int32_t a, std::int32_t b) {
  const auto num_bodies = static_cast<std::int32_t>(bodies.size());
  if (a >= num_bodies) return bodies[b].law;
  if (b >= num_bodies) return bodies[a].law;
  const HardLaw &p = bodies[a].law, &q = bodies[b].law;
  return {.friction = std::min(p.friction, q.friction),
          .restitution = std::min(p.restitution, q.restitution),
          .stiffness = p.stiffness * q.stiffness / (p.stiffness + q.stiffness),
          .rolling = std::min(p.rolling, q.rolling)};
}

}  // namespace gabion::mpm
