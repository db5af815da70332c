// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/supports/embedded_lines.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "common/mechanics/mesh/coincident_nodes.hpp"
#include "common/mechanics/ranks/text.hpp"
#include "fem_solver/stress/cells_of_materials.hpp"
#include "fem_solver/supports/boundary_conditions.hpp"

namespace gabion::fem {

namespace {

/// Refuse conditions and loads at nodes that are no unknowns.
template <int dim>
void refuse_conditions_on_embedded(const FemSettings<dim>& s) {
  if (s.embedded.nodes.empty()) return;
  const auto refuse = [](const std::string& where, const std::string& what) {
    throw ConfigError(
        fmt::format("{}: found {} of embedded lines, allowed: groups and points "
                    "without them; these nodes move with the cells around them",
                    where, what));
  };
  const auto check_group = [&](const std::string& group, const std::string& where) {
    for (const std::int32_t i : s.ranks.group_nodes(s.mesh, group, where)) {
      if (s.embedded.contains(i)) refuse(where, fmt::format("group \"{}\" with nodes", group));
    }
  };
  const auto check_places = [&](const auto& items) {
    for (const auto& item : items) {
      if (!item.point) {
        check_group(item.group, item.where);
      } else if (s.embedded.contains(node_at(s.mesh, s.ranks, *item.point, item.where))) {
        refuse(item.where, "a node");
      }
    }
  };
  for (const auto& item : s.supports) check_group(item.group, item.where);
  for (const auto& item : s.prescribed) check_group(item.group, item.where);
  for (const auto& item : s.rigid_links) check_group(item.group, item.where);
  for (const auto& item : s.tractions) check_group(item.group, item.where);
  for (const auto& item : s.interfaces) {
    for (const std::string& group : item.groups) check_group(group, item.where);
  }
  check_places(s.loads);
  check_places(s.point_masses);
  check_places(s.springs);
  check_places(s.dashpots);
}

/// Refuse two bars in one place, which would both count. Cells and lines on the same nodes are
/// checked when the mesh is read.
template <int dim>
void refuse_doubled_lines(const FemSettings<dim>& s) {
  const auto place = nodes_in_place<dim>(s.mesh.nodes, coincidence_distance(s.mesh));
  const auto text = [&](std::int32_t i) {
    const Vector<dim>& x = s.mesh.nodes[i];
    return fmt::format("({:.6g})", fmt::join(x.data(), x.data() + dim, ", "));
  };
  std::map<std::pair<std::int32_t, std::int32_t>, const LineMaterial*> known;
  for (const LineMaterial& material : s.line_materials) {
    if (!material.embedded) continue;
    for (const std::int32_t line : lines_of(s.mesh, material)) {
      const auto ends = s.mesh.line(line);
      const auto [first, added] =
          known.try_emplace(std::minmax(place[ends[0]], place[ends[1]]), &material);
      if (added) continue;
      throw ConfigError(fmt::format(
          "{}: found a line of group \"{}\" from {} to {} in the place of one of group "
          "\"{}\"; both would have stiffness there, allowed: each bar once, with all of "
          "its \"area\"",
          material.where, material.group, text(ends[0]), text(ends[1]), first->second->group));
    }
  }
}

}  // namespace

template <int dim>
void embed_lines(FemSettings<dim>& settings, MeshConnection<dim>& connection) {
  together<ConfigError>(settings.ranks.comm(), [&] {
    settings.embedded =
        find_embedded_nodes<dim>(settings.mesh, settings.line_materials, settings.ranks);
    if (!settings.embedded.nodes.empty()) refuse_doubled_lines(settings);
  });
  if (settings.embedded.nodes.empty()) return;
  connection = connection_of(without_embedded_lines<dim>(settings.mesh, settings.line_materials));
  refuse_conditions_on_embedded(settings);
}

template void embed_lines(FemSettings<2>&, MeshConnection<2>&);
template void embed_lines(FemSettings<3>&, MeshConnection<3>&);

}  // namespace gabion::fem
