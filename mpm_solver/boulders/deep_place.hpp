// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "mpm_solver/boulders/hard_contact.hpp"

namespace gabion::mpm {

/// A place where a sphere or ellipsoid is deeper than it may be: beyond that depth the nearest
/// place of a surface is another one, and the body would pass.
struct DeepPlace {
  std::int32_t body = -1, other = -1;  ///< no body: there is none; others than bodies: surfaces
  double depth = 0, most = 0;          ///< [m]
};

[[noreturn]] inline void refuse(const std::vector<HardBody>& bodies, const DeepPlace& place) {
  const bool is_body = place.other < static_cast<std::int32_t>(bodies.size());
  const std::string other = is_body ? fmt::format("\"{}\"", bodies[place.other].name) : "a surface";
  throw ConvergenceError(
      fmt::format("boulder \"{}\" is {:.4g} m deep in {}, allowed: a quarter of its radius or, of "
                  "an ellipsoid, of half its length across the contact, {:.4g} m; give it a larger "
                  "\"stiffness\", now {:.4g} N/m^2, or a smaller speed",
                  bodies[place.body].name, place.depth, other, place.most,
                  bodies[place.body].law.stiffness),
      "boulders");
}

}  // namespace gabion::mpm
