// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "common/mechanics/mesh/mesh.hpp"

namespace gabion {

/// Numbers of the nodes, cells and facets of a part in the whole mesh. Those of the part are
/// numbered anew, 0, 1, ..., in the order of their numbers in the whole.
struct PartNumbers {
  std::vector<std::int32_t> nodes;   ///< in the whole, ascending
  std::vector<std::int32_t> cells;   ///< in the whole, ascending
  std::vector<std::int32_t> lines;   ///< in the whole, ascending
  std::vector<std::int32_t> sheets;  ///< in the whole, ascending
  /// Places of the facets of the part in each group of the whole, ascending.
  std::map<std::string, std::vector<std::int64_t>> facets;
  std::int32_t num_nodes = 0;  ///< of the whole
  std::int32_t num_cells = 0;  ///< of the whole
  std::int32_t num_lines = 0;  ///< of the whole
};

/// Some cells, lines and sheets of a mesh and their nodes. It has all groups of the whole, with its
/// own facets, cells, lines, sheets and nodes.
template <int dim>
struct MeshPart {
  Mesh<dim> mesh;
  PartNumbers numbers;
};

/// Makes the wanted rectangles or bricks of box_mesh() alone, not the whole mesh.
/// @param wanted  tells by the centre [m]
/// @throws ConfigError  as box_mesh()
template <int dim>
MeshPart<dim> box_part(const BoxShape<dim>& box,
                       const std::function<bool(const Vector<dim>&)>& wanted);

/// Centres of rectangles or bricks `first` to `last` - 1 of a box, in the order of their cells [m].
template <int dim>
std::vector<Vector<dim>> brick_centres(const BoxShape<dim>& box, std::int32_t first,
                                       std::int32_t last);

/// Gives out the parts of a mesh one after the other. Refers to the mesh.
template <int dim>
class MeshParts {
 public:
  /// @param part_of_element  num_elements
  MeshParts(const Mesh<dim>& mesh, std::vector<int> part_of_element);

  /// A part that was not given out yet. A facet of a group goes to the first part given out that
  /// has its nodes.
  MeshPart<dim> take(int part);

 private:
  void take_facets(MeshPart<dim>& part);
  void take_groups(MeshPart<dim>& part) const;

  const Mesh<dim>& mesh_;
  std::vector<int> part_of_element_;
  std::map<std::string, std::vector<char>> given_;  // of the facets of each group
  std::vector<std::int32_t> places_;  // of the nodes in the part at hand; -1: not in it
};

}  // namespace gabion
