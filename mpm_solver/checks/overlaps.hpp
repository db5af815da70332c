// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include "mpm_solver/mpm_config.hpp"

namespace gabion::mpm {

/// Look whether bodies, or parts of the mesh of one, lie in each other: the same room would hold
/// the mass of both. Measured by the material points of one that lie in cells of the other. Warns
/// where these are less than a hundredth of the smaller body's.
/// @param settings  with the layouts of the bodies
/// @param points    of this rank, as they were laid
/// @throws ConfigError  more than that: which bodies, where, volume and mass
/// @note Collective.
template <int dim>
void check_overlaps(MPI_Comm comm, const MpmSettings<dim>& settings,
                    const MaterialPoints<dim>& points);

}  // namespace gabion::mpm
