// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step/grid_exits.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "common/mechanics/mesh/boundary.hpp"
#include "mpm_solver/contact/surface_features.hpp"
#include "mpm_solver/stress/point_motion.hpp"

namespace gabion::mpm {

namespace {

// Distances are equal if they differ by less than this share of half the shortest edge.
constexpr double same_place = 1e-6;

template <int dim>
double shortest_edge_of_all(const BackgroundGrid<dim>& grid) {
  if (grid.box) return grid.box->spacing.minCoeff();
  double shortest = std::numeric_limits<double>::infinity();
  for (std::int32_t c = 0; c < grid.num_cells(); ++c) {
    shortest = std::min(shortest, shortest_edge(grid, c));
  }
  return shortest;
}

}  // namespace

template <int dim>
GridExits<dim>::GridExits(const BackgroundGrid<dim>& grid)
    : grid_(grid), safe_distance_(0.5 * shortest_edge_of_all(grid)) {
  if (grid.box) {
    for (const auto& [name, facets] : grid.box->sides()) {
      outer_.insert(outer_.end(), facets.begin(), facets.end());
    }
    longest_ = grid.box->spacing.norm();
    return;
  }
  const Mesh<dim>& mesh = grid.stored->mesh;
  outer_ = boundary_facets(mesh);
  std::vector<bool> outer(mesh.nodes.size(), false);
  for (const std::int32_t node : outer_) outer[node] = true;
  at_edge_.resize(mesh.num_cells());
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
    const auto nodes = mesh.cell(c);
    at_edge_[c] = std::any_of(nodes.begin(), nodes.end(), [&](auto node) { return outer[node]; });
    for (const std::int32_t node : nodes) {
      longest_ = std::max(longest_, (mesh.nodes[node] - mesh.nodes[nodes[0]]).norm());
    }
  }
}

template <int dim>
bool GridExits<dim>::at_edge(std::int32_t cell) const {
  return grid_.box ? grid_.box->at_side(cell) : at_edge_[cell];
}

template <int dim>
typename GridExits<dim>::Exit GridExits<dim>::first(const MaterialPoints<dim>& points,
                                                    const PointWeights<dim>& weights,
                                                    const GridNodes<dim>& nodes,
                                                    std::span<const double> du,
                                                    const Refuse& refuse) const {
  double largest = 0;
  for (const double component : du) largest = std::max(largest, std::abs(component));
  const bool all = largest * std::sqrt(double{dim}) > safe_distance_;
  GroupDisplacements<dim> of_group;
  for (const CellGroup& group : weights.groups) {
    if (!all && !at_edge(points.cell[weights.point[group.first]]) && grid_.patches.size() == 0) {
      continue;
    }
    nodes.gather(weights.nodes_of(group), du, of_group.data());
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const std::int32_t p = weights.point[e];
      const Vector<dim> x = points.x[p] + point_displacement(weights, e, of_group.data());
      if (grid_.locate(x, points.cell[p]) < 0 && refuse({p, x})) return {p, x};
    }
  }
  return {};
}

// Distance to the nearest of these facets [m]; infinite where none is within reach of a cell.
template <int dim>
double GridExits<dim>::distance(std::span<const std::int32_t> facets, const Vector<dim>& x) const {
  const auto width = static_cast<std::size_t>(num_nodes(facet_type(grid_.cell_type)));
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t f = 0; f < facets.size(); f += width) {
    if ((grid_.node(facets[f]) - x).norm() > 2 * longest_) continue;
    std::array<Vector<dim>, dim> corners;
    for (std::size_t fan = 0; fan + dim <= width; ++fan) {  // a quadrilateral is two triangles
      corners[0] = grid_.node(facets[f]);
      for (std::size_t k = 1; k < dim; ++k) corners[k] = grid_.node(facets[f + fan + k]);
      least = std::min(least, (closest_place<dim>(corners, x).x - x).norm());
    }
  }
  return least;
}

template <int dim>
std::vector<std::string> GridExits<dim>::sides(const Vector<dim>& from, std::int32_t cell,
                                               const Vector<dim>& to) const {
  double inside = 0, outside = 1;
  for (double middle = 0.5; middle > inside && middle < outside; middle = (inside + outside) / 2) {
    (grid_.locate(from + middle * (to - from), cell) < 0 ? outside : inside) = middle;
  }
  const Vector<dim> place = from + inside * (to - from);
  const double least = distance(outer_, place) + same_place * safe_distance_;
  std::vector<std::string> names;
  for (const auto& [name, facets] : grid_.facet_groups) {
    if (distance(facets, place) <= least) names.push_back(name);
  }
  return names;
}

template class GridExits<2>;
template class GridExits<3>;

}  // namespace gabion::mpm
