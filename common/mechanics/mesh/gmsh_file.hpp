// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/mechanics/elements/cell_type.hpp"

namespace gabion {

/// Contents of a Gmsh file of format 4.1, with the file's own numbers (Gmsh reference manual, "MSH
/// file format"). Sections beyond names, entities, nodes and elements are passed over.
struct GmshFile {
  struct ElementBlock {
    int dimension;
    int entity;
    int type;                          ///< Gmsh's number, see cell_type_of_gmsh()
    std::vector<std::uint64_t> nodes;  ///< num_elements x nodes of the type, node tags
    std::vector<std::uint64_t> tags;   ///< num_elements, the elements' own
  };
  using DimensionAndTag = std::pair<int, int>;

  std::map<DimensionAndTag, std::string> physical_names;
  std::map<DimensionAndTag, std::vector<int>> physical_tags;  ///< by entity; signs dropped
  std::vector<std::uint64_t> node_tags;
  std::vector<std::array<double, 3>> node_positions;
  std::vector<ElementBlock> element_blocks;
};

/// @throws ConfigError  "<path>: line or byte n, section $X: ..."
GmshFile read_gmsh_file(const std::string& path);

/// None for types that are not read.
std::optional<CellType> cell_type_of_gmsh(int type);
/// Nodes of a Gmsh element type; 0 for types that are not read.
int gmsh_num_nodes(int type);

}  // namespace gabion
