// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <vector>

#include "mpm_solver/boulders/boulder_settings.hpp"
#include "mpm_solver/contact/contact_settings.hpp"
#include "mpm_solver/points/material_points.hpp"

namespace gabion::mpm {

/// Take the points out that lie in boulders of BoulderSettings::removes_soil at the start, with
/// their centre or deeper than a contact sphere may; log their mass, and the mass of soil in the
/// volume of the boulder.
/// @param walls  of the run, those of the boulders at the end
/// @throws ConfigError  a body would have no points left
/// @note Collective.
template <int dim>
void remove_soil_inside(MPI_Comm comm, const std::vector<BoulderSettings<dim>>& boulders,
                        const std::vector<RigidWallSettings<dim>>& walls,
                        MaterialPoints<dim>& points);

}  // namespace gabion::mpm
