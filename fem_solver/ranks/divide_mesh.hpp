// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <set>
#include <string>

#include "common/mechanics/mesh/connected_parts.hpp"
#include "common/mechanics/mesh/mesh.hpp"
#include "common/settings/config_reader.hpp"
#include "common/settings/scene.hpp"
#include "fem_solver/ranks/mesh_ranks.hpp"

namespace gabion::fem {

/// The mesh of the structure as a rank knows it.
template <int dim>
struct RankedMesh {
  Mesh<dim> mesh;   ///< its part
  MeshRanks ranks;  ///< how the part lies in the whole
  /// Connection of the whole mesh where it comes from a file, on the rank that reads it; else
  /// without parts.
  MeshConnection<dim> connection;
};

/// This rank's part of a mesh: planes divide space so that the ranks have equal numbers of cells
/// (bisect). Of a box each rank makes only its own bricks; a file is read by the first rank, which
/// sends the parts one after the other.
/// @param fem    reader of fem.json; its "mesh" is read
/// @param lines  groups whose lines are cells
/// @throws ConfigError  as read_mesh(); on all ranks
/// @note Collective.
template <int dim>
RankedMesh<dim> read_mesh_of_rank(const Scene& scene, ConfigReader& fem, MPI_Comm comm,
                                  const std::set<std::string>& lines = {});

}  // namespace gabion::fem
