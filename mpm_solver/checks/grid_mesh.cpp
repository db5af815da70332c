// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/checks/grid_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "common/base/log.hpp"
#include "common/mechanics/mesh/connected_parts.hpp"

namespace gabion::mpm {

namespace {

/// 1 for the nodes that walls of some phase hold.
template <int dim>
std::vector<char> nodes_of_walls(const BackgroundGrid<dim>& grid,
                                 const std::vector<Phase>& phases) {
  std::vector<char> held(grid.num_nodes_total(), 0);
  for (const Phase& phase : phases) {
    for (const WallSettings& wall : phase.walls) {
      const auto group = grid.facet_groups.find(wall.group);
      if (group == grid.facet_groups.end()) continue;  // refused where the walls are made
      for (const std::int32_t i : group->second) held[i] = 1;
    }
  }
  return held;
}

}  // namespace

template <int dim>
void check_grid_mesh(const ConfigReader& in, const BackgroundGrid<dim>& grid,
                     const std::vector<Phase>& phases) {
  if (!grid.stored || grid.stored->mesh.file.empty()) return;
  const Mesh<dim>& mesh = grid.stored->mesh;
  const auto connection = connection_of(mesh);
  const auto held = nodes_of_walls(grid, phases);
  const bool open =
      std::ranges::any_of(connection.unjoined, [&](std::int32_t i) { return !held[i]; });
  if (open) {
    in.fail("grid",
            fmt::format("found {}: soil in one part would not feel soil in the other; allowed: a "
                        "grid in one piece ({}), or a slit with \"walls\" on both sides",
                        unjoined_text(connection), how_to_join));
  }
  if (connection.parts.size() > 1 && connection.unjoined.empty()) {
    log::warn("{}: found {} parts that are not connected, the second one {}", in.where("grid"),
              connection.parts.size(), text_of(connection.parts[1]));
  }
}

template void check_grid_mesh(const ConfigReader&, const BackgroundGrid<2>&,
                              const std::vector<Phase>&);
template void check_grid_mesh(const ConfigReader&, const BackgroundGrid<3>&,
                              const std::vector<Phase>&);

}  // namespace gabion::mpm
