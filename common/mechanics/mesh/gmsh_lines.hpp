// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>

#include "common/mechanics/mesh/doubled_elements.hpp"

namespace gabion {

/// Collects the line cells of a Gmsh file. A line counts once though its entity belongs to several
/// physical groups and the file has it once for each of them. Refers to its arguments.
template <int dim>
class GmshLines {
 public:
  GmshLines(const MeshOrigin& origin, Mesh<dim>& mesh) : origin_(origin), mesh_(mesh) {}

  /// @param groups  of the block that take its lines as cells
  /// @param nodes   of the lines in the mesh, two a line
  /// @throws ConfigError  a line without length; one between the nodes of another
  void add(const GmshFile::ElementBlock& block, std::span<const std::string> groups,
           std::span<const std::int32_t> nodes);

 private:
  bool is_new(const FileElement& element, std::int32_t i, std::int32_t j);

  const MeshOrigin& origin_;
  Mesh<dim>& mesh_;
  std::map<std::pair<std::int32_t, std::int32_t>, FileElement> known_;  // by nodes, ascending
};

}  // namespace gabion
