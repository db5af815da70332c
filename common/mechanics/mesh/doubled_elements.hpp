// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/mechanics/mesh/boundary.hpp"
#include "common/mechanics/mesh/gmsh_file.hpp"
#include "common/mechanics/mesh/mesh.hpp"

namespace gabion {

/// An element of a Gmsh file.
struct FileElement {
  const GmshFile::ElementBlock* block;
  std::uint64_t tag;
};

/// Origin of a mesh, for messages about its elements.
struct MeshOrigin {
  const GmshFile& file;
  const std::string& path;
  std::vector<FileElement> cells;                          ///< of each cell
  std::map<std::string, std::vector<FileElement>> facets;  ///< of each facet of each group
};

/// Physical groups of the elements of a block: by name, those without one by number.
std::vector<std::string> group_names(const GmshFile& file, const GmshFile::ElementBlock& block);

/// A cell counts once though its entity belongs to several physical groups and the file has it once
/// for each of them, as Gmsh converts files of format 2: the groups are labels. Every other two
/// cells in one place would double mass and stiffness.
/// @throws ConfigError  naming the first two with their groups; also where their nodes are other
///                      ones in the same places
template <int dim>
void settle_doubled_cells(MeshOrigin& origin, Mesh<dim>& mesh);

/// Each facet of a group counts once, however often the file has it.
/// @throws ConfigError  it has one between two cells in both senses of rotation
template <int dim>
void settle_doubled_facets(MeshOrigin& origin, Mesh<dim>& mesh);

/// @throws ConfigError  two cells on one side of a facet that they share, which overlap there
template <int dim>
void refuse_cells_on_one_side(const MeshOrigin& origin, const FacetOwners& owners,
                              const Mesh<dim>& mesh);

}  // namespace gabion
