// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/small_cuts.hpp"

#include <limits>
#include <numeric>
#include <vector>

#include "common/mechanics/ranks/sum.hpp"

namespace gabion::mpm {

namespace {

/// For each grid node with `light` set: the nearest node without it in the cells with points; -1
/// where there is none.
template <int dim>
std::vector<std::int32_t> nearest_kept_nodes(MPI_Comm comm, const BackgroundGrid<dim>& grid,
                                             const PointWeights<dim>& weights,
                                             const std::vector<char>& light) {
  std::vector<std::int32_t> occupied(static_cast<std::size_t>(grid.mesh.num_cells()), 0);
  for (const CellGroup& group : weights.groups) occupied[group.cell] = 1;
  sum_over_ranks(comm, std::span<std::int32_t>(occupied));
  std::vector<std::int32_t> nearest(light.size(), -1);
  std::vector<double> distance(light.size(), std::numeric_limits<double>::infinity());
  for (std::int32_t c = 0; c < grid.mesh.num_cells(); ++c) {
    if (occupied[c] == 0) continue;
    for (const std::int32_t i : grid.mesh.cell(c)) {
      if (light[i] == 0) continue;
      for (const std::int32_t k : grid.mesh.cell(c)) {
        if (light[k] != 0) continue;
        const double d = (grid.mesh.nodes[i] - grid.mesh.nodes[k]).norm();
        if (d >= distance[i]) continue;
        distance[i] = d;
        nearest[i] = k;
      }
    }
  }
  return nearest;
}

}  // namespace

template <int dim>
std::int32_t drop_light_nodes(MPI_Comm comm, const BackgroundGrid<dim>& grid,
                              const PointWeights<dim>& weights, double mass_share,
                              std::span<const std::int32_t> keep, GridNodes<dim>& nodes) {
  const double limit = mass_share * std::accumulate(nodes.m.begin(), nodes.m.end(), 0.0) /
                       static_cast<double>(nodes.m.size());
  std::vector<char> light(nodes.active.size(), 0);
  for (std::int32_t i = 0; i < nodes.size(); ++i) light[nodes.grid_node[i]] = nodes.m[i] < limit;
  for (const std::int32_t node : keep) light[node] = 0;
  const auto leader = nearest_kept_nodes(comm, grid, weights, light);

  const std::vector<std::int32_t> before = std::move(nodes.grid_node);
  nodes.grid_node.clear();
  std::vector<std::int32_t> dropped;
  for (const std::int32_t node : before) {
    if (light[node] != 0 && leader[node] >= 0) {
      dropped.push_back(node);
    } else {
      nodes.active[node] = nodes.size();
      nodes.grid_node.push_back(node);
    }
  }
  for (const std::int32_t node : dropped) nodes.active[node] = nodes.active[leader[node]];
  return static_cast<std::int32_t>(dropped.size());
}

template std::int32_t drop_light_nodes<2>(MPI_Comm, const BackgroundGrid<2>&,
                                          const PointWeights<2>&, double,
                                          std::span<const std::int32_t>, GridNodes<2>&);
template std::int32_t drop_light_nodes<3>(MPI_Comm, const BackgroundGrid<3>&,
                                          const PointWeights<3>&, double,
                                          std::span<const std::int32_t>, GridNodes<3>&);

}  // namespace gabion::mpm
