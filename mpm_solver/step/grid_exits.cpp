// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step/grid_exits.hpp"

#include <algorithm>
#include <limits>

#include "common/mechanics/mesh/boundary.hpp"
#include "mpm_solver/stress/point_motion.hpp"

namespace gabion::mpm {

namespace {

template <int dim>
double shortest_edge_of_all(const Mesh<dim>& mesh) {
  double shortest = std::numeric_limits<double>::infinity();
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
    shortest = std::min(shortest, shortest_edge(mesh, c));
  }
  return shortest;
}

}  // namespace

template <int dim>
GridExits<dim>::GridExits(const BackgroundGrid<dim>& grid)
    : grid_(grid), safe_distance_(0.5 * shortest_edge_of_all(grid.mesh)) {
  const Mesh<dim>& mesh = grid.mesh;
  std::vector<bool> outer(mesh.nodes.size(), false);
  for (const std::int32_t node : boundary_facets(mesh)) outer[node] = true;
  at_edge_.resize(mesh.num_cells());
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
    const auto nodes = mesh.cell(c);
    at_edge_[c] = std::any_of(nodes.begin(), nodes.end(), [&](auto node) { return outer[node]; });
  }
}

template <int dim>
typename GridExits<dim>::Exit GridExits<dim>::first(const MaterialPoints<dim>& points,
                                                    const PointWeights<dim>& weights,
                                                    const GridNodes<dim>& nodes,
                                                    std::span<const double> du) const {
  double largest = 0;
  for (const double component : du) largest = std::max(largest, std::abs(component));
  const bool all = largest * std::sqrt(double{dim}) > safe_distance_;
  GroupDisplacements<dim> of_group;
  for (const CellGroup& group : weights.groups) {
    if (!all && !at_edge_[points.cell[weights.point[group.first]]] && grid_.patches.size() == 0) {
      continue;
    }
    nodes.gather(weights.nodes_of(group), du, of_group.data());
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const std::int32_t p = weights.point[e];
      const Vector<dim> x = points.x[p] + point_displacement(weights, e, of_group.data());
      if (cell_of(grid_, x, points.cell[p]) < 0) return {p, x};
    }
  }
  return {};
}

template <int dim>
std::string GridExits<dim>::nearest_group(const Vector<dim>& x) const {
  const Mesh<dim>& mesh = grid_.mesh;
  const auto width = static_cast<std::size_t>(num_nodes(facet_type(mesh.cell_type)));
  std::string nearest;
  double distance = std::numeric_limits<double>::infinity();
  for (const auto& [name, facets] : mesh.facet_groups) {
    for (std::size_t f = 0; f < facets.size(); f += width) {
      Vector<dim> centre = Vector<dim>::Zero();
      for (std::size_t i = 0; i < width; ++i) {
        centre += mesh.nodes[facets[f + i]] / static_cast<double>(width);
      }
      if (!((centre - x).norm() < distance)) continue;
      distance = (centre - x).norm();
      nearest = name;
    }
  }
  return nearest;
}

template class GridExits<2>;
template class GridExits<3>;

}  // namespace gabion::mpm
