// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/stress/cell_quadrature.hpp"

#include <algorithm>
#include <set>

#include "common/mechanics/elements/shape_functions.hpp"

namespace gabion::mpm {

const char* quadrature_name(Quadrature quadrature) {
  return quadrature == Quadrature::cells ? "cells" : "points";
}

template <int dim>
OpenNodes open_nodes(const BackgroundGrid<dim>& grid, const std::vector<WallSettings>& walls) {
  const auto n = static_cast<std::size_t>(num_nodes(facet_type(grid.cell_type)));
  const auto key = [n](const std::int32_t* facet) {
    std::vector<std::int32_t> nodes(facet, facet + n);
    std::sort(nodes.begin(), nodes.end());
    return nodes;
  };
  std::set<std::vector<std::int32_t>> walled;
  for (const WallSettings& wall : walls) {
    if (wall.motion.moves()) continue;
    const auto& facets = find_facets(grid.facet_groups, wall.group, wall.where);
    for (std::size_t k = 0; k < facets.size(); k += n) walled.insert(key(&facets[k]));
  }
  OpenNodes open(grid.num_nodes_total(), 0);
  const auto add = [&](const std::vector<std::int32_t>& facets) {
    for (std::size_t k = 0; k < facets.size(); k += n) {
      if (walled.contains(key(&facets[k]))) continue;
      for (std::size_t i = k; i < k + n; ++i) open.at(facets[i]) = 1;
    }
  };
  if (grid.box) {
    for (const auto& side : grid.box->sides()) add(side.second);
  } else {
    add(boundary_facets(grid.stored->mesh));
  }
  return open;
}

template <int dim>
CellQuadrature<dim>::CellQuadrature(const BackgroundGrid<dim>& grid) : grid_(grid) {
  if (grid.box) {
    of_box_ = mean_gradients(0);
    return;
  }
  cells_around_.assign(grid.num_nodes_total(), 0);
  for (std::int32_t c = 0; c < grid.num_cells(); ++c) {
    for (const std::int32_t node : grid.cell(c)) ++cells_around_[node];
    volumes_.push_back(cell_volume(grid, c));
  }
}

template <int dim>
std::int32_t CellQuadrature<dim>::cells_around(std::int32_t grid_node) const {
  if (!grid_.box) return cells_around_[grid_node];
  return grid_.box->num_cells_around(grid_node);
}

template <int dim>
double CellQuadrature<dim>::volume_of(std::int32_t cell) const {
  return grid_.box ? cell_volume(grid_, cell) : volumes_[cell];
}

template <int dim>
typename CellQuadrature<dim>::MeanGradients CellQuadrature<dim>::mean_gradients(
    std::int32_t cell) const {
  if (of_box_) return *of_box_;
  static const auto rule = gauss_rule<dim>(BoxGrid<dim>::cell_type, 2);  // exact
  const int n = grid_.nodes_per_cell();
  MeanGradients mean;
  mean.fill(Vector<dim>::Zero());
  Vector<dim> corners[max_cell_nodes];
  grid_.corners(cell, corners);
  double volume = 0;
  ShapeValues<dim> shape;
  for (const QuadraturePoint<dim>& point : rule) {
    shape_functions<dim>(grid_.cell_type, point.xi, shape);
    const double dV = point.weight * map_gradients<dim>(grid_.cell_type, corners, shape);
    for (int i = 0; i < n; ++i) mean[i] += dV * shape.dN[i];
    volume += dV;
  }
  for (int i = 0; i < n; ++i) mean[i] /= volume;
  return mean;
}

template <int dim>
void CellQuadrature<dim>::list_runs(const MaterialPoints<dim>& points,
                                    const PointWeights<dim>& weights) {
  runs_.clear();
  bodies_.assign(grid_.num_cells(), 0);
  filled_.assign(grid_.num_cells(), 0);
  for (const CellGroup& group : weights.groups) {
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const std::int32_t p = weights.point[e], cell = points.cell[p];
      if (e == group.first || cell != runs_.back().cell) {
        runs_.push_back({.cell = cell, .first = e, .last = e});
        ++bodies_.at(cell);
      }
      ++runs_.back().last;
      filled_.at(cell) += points.V0[p] * points.J[p];
    }
  }
}

template <int dim>
void CellQuadrature<dim>::find_surrounded(const OpenNodes& open, const GridNodes<dim>& nodes) {
  std::vector<double> filled_around(nodes.size(), 0);
  filled_.for_each([&](std::size_t cell, double volume) {
    const auto c = static_cast<std::int32_t>(cell);
    if (volume < least_filling * volume_of(c)) return;
    for (const std::int32_t node : grid_.cell(c)) ++filled_around[nodes.active[node]];
  });
  nodes.shared.sum(filled_around, 1);
  surrounded_.resize(nodes.size());
  for (std::int32_t i = 0; i < nodes.size(); ++i) {
    const std::int32_t node = nodes.place(i);
    surrounded_[i] =
        open[node] == 0 && filled_around[i] == cells_around(node) && !nodes.is_doubled(i);
  }
}

template <int dim>
bool CellQuadrature<dim>::is_inside(std::int32_t cell, const GridNodes<dim>& nodes) const {
  const CellList corners = grid_.cell(cell);
  return bodies_[cell] == 1 && std::all_of(corners.begin(), corners.end(), [&](std::int32_t node) {
           return surrounded_[nodes.active[node]] == 1;
         });
}

template <int dim>
void CellQuadrature<dim>::shift_gradients(const Run& run, const MaterialPoints<dim>& points,
                                          PointWeights<dim>& weights) const {
  MeanGradients shift = mean_gradients(run.cell);
  const double over_volume = 1 / volume_of(run.cell);
  const int n = grid_.nodes_per_cell();
  for (std::int32_t e = run.first; e < run.last; ++e) {
    const double share = over_volume * weights.volume[e] * points.J[weights.point[e]];
    for (int i = 0; i < n; ++i) shift[i] -= share * weights.grad_of(e)[i];
  }
  for (std::int32_t e = run.first; e < run.last; ++e) {
    for (int i = 0; i < n; ++i) weights.grad_N[weights.starts[e] + i] += shift[i];
  }
}

template <int dim>
void CellQuadrature<dim>::correct(const OpenNodes& open, const MaterialPoints<dim>& points,
                                  const GridNodes<dim>& nodes, PointWeights<dim>& weights) {
  list_runs(points, weights);
  find_surrounded(open, nodes);
  num_inside_ = 0;
  for (const Run& run : runs_) {
    if (!is_inside(run.cell, nodes)) continue;
    ++num_inside_;
    const double factor = volume_of(run.cell) / filled_[run.cell];
    for (std::int32_t e = run.first; e < run.last; ++e) weights.volume[e] *= factor;
    if (!grid_.is_simplex()) shift_gradients(run, points, weights);
  }
}

template OpenNodes open_nodes<2>(const BackgroundGrid<2>&, const std::vector<WallSettings>&);
template OpenNodes open_nodes<3>(const BackgroundGrid<3>&, const std::vector<WallSettings>&);
template class CellQuadrature<2>;
template class CellQuadrature<3>;

}  // namespace gabion::mpm
