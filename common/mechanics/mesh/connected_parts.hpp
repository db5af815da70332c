// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "common/mechanics/mesh/mesh.hpp"

namespace gabion {

/// Cells and lines of a mesh that hang together by their nodes.
template <int dim>
struct ConnectedPart {
  std::int32_t num_cells = 0;          ///< with lines
  Eigen::AlignedBox<double, dim> box;  ///< around it [m]
  std::set<std::string> groups;        ///< groups of facets and nodes that have nodes of it
  std::int32_t num_touching = 0;       ///< of its nodes: a node of another part is in their place
};

/// Connection of the cells of a mesh.
template <int dim>
struct MeshConnection {
  std::vector<ConnectedPart<dim>> parts;    ///< in the order of their first cells
  std::vector<std::int32_t> unjoined;       ///< nodes in the place of another, all of a place
  std::int32_t num_unjoined = 0;            ///< places with several nodes
  std::vector<Vector<dim>> first_unjoined;  ///< three of these places at most [m]
};

/// @see coincidence_distance() for what one place is
template <int dim>
MeshConnection<dim> connection_of(const Mesh<dim>& mesh);

/// "4 places with several nodes that are not joined, such as (0, 1), (1, 1)". @pre there are some
template <int dim>
std::string unjoined_text(const MeshConnection<dim>& connection);

/// "12 cells from (0, 1) to (1, 2)"
template <int dim>
std::string text_of(const ConnectedPart<dim>& part);

/// Command of Gmsh that joins the parts of a model, for messages.
inline constexpr const char* how_to_join =
    "join them where they meet (Gmsh: BooleanFragments, or Coherence Mesh)";

}  // namespace gabion
