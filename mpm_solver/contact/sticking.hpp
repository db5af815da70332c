// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace gabion::mpm {

/// Coefficient of friction of surfaces that stick. Where soil separates, the tangential traction
/// then goes to nothing with the pressure; without a bound it would jump, and soil without cohesion
/// would have no state of balance on either side of the jump.
inline constexpr double sticking = 100;

}  // namespace gabion::mpm
