// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "common/mechanics/mesh/mesh.hpp"

namespace gabion {

/// The mesh of a Gmsh file, read for some of its facet groups: those have to be of facets of cells.
/// Facets of other groups that belong to no cell, such as ropes in the plane or the meshes of a net
/// in space, are left out.
/// @throws ConfigError  as read_gmsh()
template <int dim>
Mesh<dim> read_gmsh_surface(const std::string& path, const std::vector<std::string>& groups);

/// Like read_mesh(), a file as read_gmsh_surface().
template <int dim>
Mesh<dim> read_surface_mesh(const Scene& scene, ConfigReader in,
                            const std::vector<std::string>& groups);

}  // namespace gabion
