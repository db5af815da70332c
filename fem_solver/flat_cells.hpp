// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "fem_solver/fem_config.hpp"

namespace gabion::fem {

/// Warn of quadrilaterals and hexahedra with full integration that are long against the thickness
/// of their part, of one or several cells: they lock in bending. On one rank, whose mesh has all
/// neighbours.
template <int dim>
void warn_of_flat_cells(const FemSettings<dim>& settings, MPI_Comm comm);

}  // namespace gabion::fem
