// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/supports/rotation_nodes.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "common/base/require.hpp"
#include "fem_solver/stress/cells_of_materials.hpp"

namespace gabion::fem {

template <int dim>
void add_rotation_nodes(const ConfigReader& in, FemSettings<dim>& s) {
  double sum = 0;
  std::size_t count = 0;
  std::vector<char> turns(s.mesh.nodes.size(), 0);
  bool any = false;
  for (const LineMaterial& material : s.line_materials) {
    if (!material.beam) continue;
    any = true;
    for (const std::int32_t l : lines_of(s.mesh, material)) {
      const auto ends = s.mesh.line(l);
      turns[ends[0]] = turns[ends[1]] = 1;
      sum += (s.mesh.nodes[ends[1]] - s.mesh.nodes[ends[0]]).norm();
      ++count;
    }
  }
  if (!any) return;
  if (!s.ranks.alone()) {
    in.fail("materials", "found \"law\" \"beam\" on several ranks, allowed: one rank");
  }
  if (count == 0) return;
  s.rotation_length = sum / static_cast<double>(count);
  s.rotation_nodes.assign(turns.size(), -1);
  for (std::size_t i = 0; i < turns.size(); ++i) {
    if (!turns[i]) continue;
    s.rotation_nodes[i] = s.mesh.num_nodes_total();
    const Vector<dim> place = s.mesh.nodes[i];
    s.mesh.nodes.push_back(place);
  }
}

namespace {

template <int dim>
void require_rotations(const FemSettings<dim>& s, const std::string& group,
                       const std::string& where, const std::string& what) {
  const auto nodes = s.ranks.group_nodes(s.mesh, group, where);
  const auto missing =
      std::ranges::find_if(nodes, [&](std::int32_t i) { return s.beam_nodes().of(i) < 0; });
  if (missing == nodes.end()) return;
  throw ConfigError(fmt::format(
      "{}: found {} of group \"{}\" with node {}, which is of no beam, allowed: groups whose nodes "
      "are all of lines with \"law\" \"beam\"",
      where, what, group, s.ranks.node_of_all(*missing)));
}

}  // namespace

template <int dim>
void check_rotations(const FemSettings<dim>& s) {
  for (const SupportSettings& support : s.supports) {
    if (support.rotations.empty()) continue;
    require_rotations(s, support.group, support.where, "\"rotations\"");
  }
  for (const LoadSettings<dim>& load : s.loads) {
    if (load.moment.isZero(0) || load.point) continue;  // at a point: BoundaryConditions
    require_rotations(s, load.group, load.where, "a \"moment\"");
  }
}

template void add_rotation_nodes(const ConfigReader&, FemSettings<2>&);
template void add_rotation_nodes(const ConfigReader&, FemSettings<3>&);
template void check_rotations(const FemSettings<2>&);
template void check_rotations(const FemSettings<3>&);

}  // namespace gabion::fem
