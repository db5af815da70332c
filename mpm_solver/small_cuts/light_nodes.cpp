// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/small_cuts/light_nodes.hpp"

#include <limits>

#include "common/mechanics/ranks/sum.hpp"

namespace gabion::mpm {

namespace {

// Mass of the points that each active node acts on.
template <int dim>
std::vector<double> mass_within_reach(MPI_Comm comm, const MaterialPoints<dim>& points,
                                      const PointWeights<dim>& weights,
                                      const GridNodes<dim>& nodes) {
  std::vector<double> reach(nodes.grid_node.size(), 0);
  for (const CellGroup& group : weights.groups) {
    const auto grid_nodes = weights.nodes_of(group);
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const std::uint8_t* local = weights.local_of(e);
      for (int i = 0; i < weights.num_nodes(e); ++i) {
        reach[nodes.active[grid_nodes[local[i]]]] += points.m[weights.point[e]];
      }
    }
  }
  sum_over_ranks(comm, std::span<double>(reach));
  return reach;
}

// The nearest heavy node of the cells of each light node, as grid nodes; -1: none.
template <int dim>
std::vector<std::int32_t> nearest_heavy(const Mesh<dim>& mesh, const WallConditions<dim>& walls,
                                        const GridNodes<dim>& nodes,
                                        const std::vector<bool>& light) {
  std::vector<std::int32_t> partner(light.size(), -1);
  std::vector<double> distance(light.size(), std::numeric_limits<double>::infinity());
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
    for (const std::int32_t from : mesh.cell(c)) {
      const std::int32_t i = nodes.active[from];
      if (i < 0 || !light[i]) continue;
      for (const std::int32_t to : mesh.cell(c)) {
        if (nodes.active[to] < 0 || light[nodes.active[to]] || walls.holds(to)) continue;
        const double d = (mesh.nodes[to] - mesh.nodes[from]).norm();
        if (d > distance[i] || (d == distance[i] && to >= partner[i])) continue;
        distance[i] = d;
        partner[i] = to;
      }
    }
  }
  return partner;
}

}  // namespace

template <int dim>
std::int32_t join_light_nodes(MPI_Comm comm, const LightNodeSearch<dim>& search,
                              GridNodes<dim>& nodes) {
  const WallConditions<dim>& walls = search.walls;
  const auto reach = mass_within_reach(comm, search.points, search.weights, nodes);
  std::vector<bool> light(reach.size());
  bool any = false;
  for (std::int32_t i = 0; i < nodes.size(); ++i) {
    light[i] = nodes.m[i] < search.share * reach[i] && !walls.holds(nodes.grid_node[i]);
    any |= light[i];
  }
  if (!any) return 0;

  const auto partner = nearest_heavy(search.grid.mesh, walls, nodes, light);
  const std::vector<std::int32_t> before = std::move(nodes.grid_node);
  nodes.grid_node.clear();
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (partner[i] >= 0) continue;
    nodes.active[before[i]] = nodes.size();
    nodes.grid_node.push_back(before[i]);
  }
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (partner[i] >= 0) nodes.active[before[i]] = nodes.active[partner[i]];
  }
  return static_cast<std::int32_t>(before.size()) - nodes.size();
}

template std::int32_t join_light_nodes<2>(MPI_Comm, const LightNodeSearch<2>&, GridNodes<2>&);
template std::int32_t join_light_nodes<3>(MPI_Comm, const LightNodeSearch<3>&, GridNodes<3>&);

}  // namespace gabion::mpm
