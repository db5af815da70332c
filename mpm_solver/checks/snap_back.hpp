// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "mpm_solver/mpm_config.hpp"

namespace gabion::mpm {

/// Refuse soils whose strength would fall faster, in the largest cells of the grid and under the
/// weight of all the bodies above each other, than the stress of a point unloads.
/// @throws ConfigError  says which slip, cell or modulus would do
template <int dim>
void require_no_snap_back(const MpmSettings<dim>& settings);

}  // namespace gabion::mpm
