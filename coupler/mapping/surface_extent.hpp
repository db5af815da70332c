// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "common/run/solver.hpp"

namespace gabion {

/// [m] The longest side of the box around a surface.
double extent(const InterfaceMesh& mesh);

/// Hint for two surfaces of which one is 1000 times as large as the other, within 5 %: words that
/// say so and name the likely cause, millimetres on one side. Else empty.
std::string unit_hint(const InterfaceMesh& structure, const InterfaceMesh& soil);

}  // namespace gabion
