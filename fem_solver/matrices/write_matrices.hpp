// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <string>

#include "fem_solver/fem_config.hpp"

namespace gabion::fem {

/// Write a structure with a mesh as matrices, as a scene's folder that reads back as the same
/// structure. Files: K.mtx, the tangent at the reference configuration; M.mtx; load.mtx (gravity
/// and constant loads, if there are any); unknowns.csv, held.csv, nodes.csv, cells.csv, fem.json,
/// and NAME.csv with the facets of each interface. Unknowns that supports hold are left out of the
/// matrices.
/// @param resolved  all of the fem.json that the settings are from
/// @throws ConfigError  something that moves or changes with time, several ranks
/// @throws Error        a file cannot be written
template <int dim>
void write_matrices(const FemSettings<dim>& settings, const Json& resolved, MPI_Comm comm,
                    const std::string& folder);

}  // namespace gabion::fem
