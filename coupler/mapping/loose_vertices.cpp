// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/mapping/loose_vertices.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

namespace gabion {

std::int64_t num_loose_vertices(const InterfaceMesh& mesh) {
  if (mesh.facets.empty()) return 0;
  std::vector<bool> loose(static_cast<std::size_t>(mesh.num_vertices()), true);
  for (const std::int64_t v : mesh.facets) loose[static_cast<std::size_t>(v)] = false;
  return std::count(loose.begin(), loose.end(), true);
}

std::string behind_hint(const InterfaceMesh& structure, const InterfaceMesh& soil) {
  const std::int64_t of_structure = num_loose_vertices(structure);
  const std::int64_t of_soil = num_loose_vertices(soil);
  if (of_structure == of_soil) return "";
  return fmt::format(
      "; {} vertices of the soil's side and {} of the structure's belong to cells behind the "
      "surface, allowed: equal \"behind\" in the surface of mpm.json and in the interface of "
      "fem.json, or none in both",
      of_soil, of_structure);
}

}  // namespace gabion
