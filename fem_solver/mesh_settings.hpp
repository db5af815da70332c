// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "fem_solver/fem_config.hpp"
#include "fem_solver/ranks/divide_mesh.hpp"

namespace gabion::fem {

/// Read the materials of cells, lines and membranes.
/// @param comm  the ranks that divide the mesh; MPI_COMM_NULL: this process has all of it
/// @throws ConfigError  membranes on several ranks
template <int dim>
void read_materials_of_all(ConfigReader& in, MPI_Comm comm, FemSettings<dim>& s);

/// The mesh, with the lines and sheets that the materials of the settings name.
/// @note Collective.
template <int dim>
RankedMesh<dim> read_mesh_with_lines(const Scene& scene, ConfigReader& in,
                                     const FemSettings<dim>& s, MPI_Comm comm);

/// Refuse "behind" with facets that are membranes: they stay when the cell under them is gone.
template <int dim>
void check_membranes_behind(const FemSettings<dim>& s);

}  // namespace gabion::fem
