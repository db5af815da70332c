// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "common/run/solver.hpp"

namespace gabion {

/// Number of vertices that no facet has; 0 of a surface of bare vertices.
std::int64_t num_loose_vertices(const InterfaceMesh& mesh);

/// End of a message about surfaces that do not fit, where the sides have unequal numbers of
/// vertices without a facet: those of cells behind the surface. Empty: as many on both sides.
std::string behind_hint(const InterfaceMesh& structure, const InterfaceMesh& soil);

}  // namespace gabion
