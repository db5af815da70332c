// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/supports/link_nodes.hpp"

#include <algorithm>
#include <map>
#include <string>
#include <variant>

#include "common/base/require.hpp"
#include "fem_solver/stress/cells_of_materials.hpp"

namespace gabion::fem {

namespace {

/// Stiffness of all springs of a link over that of the cells around it: its deformation adds a few
/// thousandths to theirs.
constexpr double link_factor = 1e3;

/// The largest modulus of the structure [Pa].
template <int dim>
double largest_modulus(const FemSettings<dim>& settings) {
  double largest = 0;
  for (const CellMaterial<dim>& material : settings.materials) {
    largest = std::max(
        largest, std::visit([](const auto& law) { return law.p_wave_modulus(); }, material.law));
  }
  for (const LineMaterial& material : settings.line_materials) {
    if (material.beam) largest = std::max(largest, material.young_modulus);
  }
  return largest;
}

/// The node of beams of a link.
template <int dim>
std::int32_t master_of(const FemSettings<dim>& settings, const RigidLinkSettings& link) {
  const auto nodes = settings.ranks.group_nodes(settings.mesh, link.beam, link.where);
  require<ConfigError>(nodes.size() == 1 && settings.beam_nodes().of(nodes[0]) >= 0,
                       "{}: found \"beam\" \"{}\" with {} nodes{}, allowed: a group of one node of "
                       "lines with \"law\" \"beam\"",
                       link.where, link.beam, nodes.size(),
                       nodes.size() == 1 ? ", which is of no beam" : "");
  return nodes[0];
}

/// The first line that is a beam and ends at the node of the link.
template <int dim>
void find_beam(const FemSettings<dim>& settings, RigidLink<dim>& link) {
  for (const LineMaterial& material : settings.line_materials) {
    if (!material.beam) continue;
    for (const std::int32_t l : lines_of(settings.mesh, material)) {
      const auto ends = settings.mesh.line(l);
      if (ends[0] != link.place && ends[1] != link.place) continue;
      link.line = l;
      link.end = ends[0] == link.place ? 0 : 1;
      return;
    }
  }
}

}  // namespace

template <int dim>
std::vector<RigidLink<dim>> rigid_links(const FemSettings<dim>& settings) {
  std::vector<RigidLink<dim>> links;
  std::map<std::int32_t, std::string> taken;  // and the group that takes it
  for (const RigidLinkSettings& item : settings.rigid_links) {
    RigidLink<dim> link;
    link.place = master_of(settings, item);
    link.rotation = settings.beam_nodes().of(link.place);
    find_beam(settings, link);
    double reach = 0;
    for (const std::int32_t i : settings.ranks.group_nodes(settings.mesh, item.group, item.where)) {
      if (i == link.place) continue;
      require<ConfigError>(taken.emplace(i, item.group).second,
                           "{}: found node {} of group \"{}\", which another link moves, allowed: "
                           "each node in one link",
                           item.where, settings.ranks.node_of_all(i), item.group);
      link.arms.push_back({i, settings.mesh.nodes[i] - settings.mesh.nodes[link.place]});
      reach = std::max(reach, link.arms.back().reach.norm());
    }
    require<ConfigError>(reach > 0,
                         "{}: found group \"{}\" without nodes away from that of \"{}\", allowed: "
                         "nodes that turn with it",
                         item.where, item.group, item.beam);
    link.stiffness = link_factor * largest_modulus(settings) * (dim == 3 ? reach : 1) /
                     static_cast<double>(link.arms.size());
    links.push_back(std::move(link));
  }
  for (std::size_t l = 0; l < links.size(); ++l) {
    require<ConfigError>(!taken.contains(links[l].place),
                         "{}: found \"beam\" \"{}\", whose node another link moves, allowed: links "
                         "that do not form chains",
                         settings.rigid_links[l].where, settings.rigid_links[l].beam);
  }
  return links;
}

template <int dim>
void check_rigid_links(const FemSettings<dim>& settings) {
  rigid_links(settings);
}

template std::vector<RigidLink<2>> rigid_links(const FemSettings<2>&);
template std::vector<RigidLink<3>> rigid_links(const FemSettings<3>&);
template void check_rigid_links(const FemSettings<2>&);
template void check_rigid_links(const FemSettings<3>&);

}  // namespace gabion::fem
