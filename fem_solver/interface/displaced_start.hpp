// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/run/solver.hpp"

namespace gabion::fem {

/// What to say of a structure that starts with its interfaces displaced by more than a hundredth of
/// their shortest edge: the soil has them at their reference places until its first step.
/// @param start  displacements of the interfaces in the initial state [m]
std::optional<std::string> displaced_start(const std::vector<InterfaceMesh>& meshes,
                                           const InterfaceValues& start);

}  // namespace gabion::fem
