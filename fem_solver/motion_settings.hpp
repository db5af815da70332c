// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "fem_solver/fem_config.hpp"

namespace gabion::fem {

/// read_motion() of a structure with a mesh: where lines may go slack or concrete cracks, the
/// scheme is by default one that creates no energy there, and a warning names others.
/// @pre materials and line materials are read
template <int dim>
void read_motion_with_lines(ConfigReader& in, FemSettings<dim>& s);

}  // namespace gabion::fem
