// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/small_cuts/light_nodes.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "common/mechanics/ranks/sum.hpp"

namespace gabion::mpm {

namespace {

// Mass of the points that each active node acts on.
template <int dim>
std::vector<double> mass_within_reach(const MaterialPoints<dim>& points,
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
  nodes.shared.sum(reach, 1);
  return reach;
}

// Kind of a grid node on any rank.
enum Weight : std::int32_t { inactive = 0, heavy = 1, light = 2 };

// The nearest heavy node of the cells of each light node, as grid nodes; -1: none.
// @param kinds  of all grid nodes
template <int dim>
std::vector<std::int32_t> nearest_heavy(const Mesh<dim>& mesh, const WallConditions<dim>& walls,
                                        const GridNodes<dim>& nodes,
                                        const std::vector<std::int32_t>& kinds) {
  std::vector<std::int32_t> partner(nodes.grid_node.size(), -1);
  std::vector<double> distance(partner.size(), std::numeric_limits<double>::infinity());
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
    for (const std::int32_t from : mesh.cell(c)) {
      const std::int32_t i = nodes.active[from];
      if (i < 0 || kinds[from] != light) continue;
      for (const std::int32_t to : mesh.cell(c)) {
        if (kinds[to] != heavy || walls.holds(to)) continue;
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
  const auto reach = mass_within_reach(search.points, search.weights, nodes);
  std::vector<std::int32_t> kinds(search.grid.mesh.nodes.size(), inactive);
  bool any = false;
  for (std::int32_t i = 0; i < nodes.size(); ++i) {
    const std::int32_t node = nodes.grid_node[i];
    const bool is_light = nodes.m[i] < search.share * reach[i] && !search.walls.holds(node);
    kinds[node] = is_light ? light : heavy;
    any |= is_light;
  }
  if (nodes.shared.all(!any)) return 0;
  max_over_ranks(comm, std::span<std::int32_t>(kinds));

  const auto partner = nearest_heavy(search.grid.mesh, search.walls, nodes, kinds);
  const std::int64_t num_before = nodes.num_of_all();
  const std::vector<std::int32_t> before = nodes.grid_node;
  std::vector<std::int32_t> rest;
  for (std::size_t i = 0; i < before.size(); ++i) {
    rest.push_back(partner[i] < 0 ? before[i] : partner[i]);
  }
  std::sort(rest.begin(), rest.end());
  rest.erase(std::unique(rest.begin(), rest.end()), rest.end());
  number_nodes(comm, search.grid, std::move(rest), nodes);
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (partner[i] < 0) continue;
    nodes.active[before[i]] = nodes.active[partner[i]];
    nodes.listed.push_back(before[i]);
  }
  return static_cast<std::int32_t>(num_before - nodes.num_of_all());
}

template std::int32_t join_light_nodes<2>(MPI_Comm, const LightNodeSearch<2>&, GridNodes<2>&);
template std::int32_t join_light_nodes<3>(MPI_Comm, const LightNodeSearch<3>&, GridNodes<3>&);

}  // namespace gabion::mpm
