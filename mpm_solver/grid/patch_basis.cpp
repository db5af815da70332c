// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/grid/patch_basis.hpp"

#include <algorithm>

#include "common/base/require.hpp"
#include "common/mechanics/elements/shape_functions.hpp"

namespace gabion::mpm {

namespace {

// Sort the points of each body by patch, cell and number (counting sort, stable), list the groups.
template <int dim>
void sort_by_patch(const CellPatches& patches, const MaterialPoints<dim>& points,
                   PointWeights<dim>& weights) {
  weights.point.resize(points.size());
  weights.groups.clear();
  weights.body_groups.assign(1, 0);
  std::vector<std::int32_t> place(patches.cells.size());  // of each cell in the order of patches
  for (std::size_t k = 0; k < place.size(); ++k) {
    place[patches.cells[k]] = static_cast<std::int32_t>(k);
  }
  std::vector<std::int32_t> next(place.size() + 1);  // entry of each cell's next point
  for (std::int32_t b = 0; b < points.num_bodies(); ++b) {
    const std::int32_t begin = points.body_starts[b];
    const std::int32_t end = points.body_starts[b + 1];
    std::fill(next.begin(), next.end(), 0);
    for (std::int32_t p = begin; p < end; ++p) ++next[place[points.cell[p]] + 1];
    next[0] = begin;
    for (std::size_t k = 1; k < next.size(); ++k) next[k] += next[k - 1];
    for (std::int32_t k = 0; k < patches.size(); ++k) {
      const std::int32_t first = next[patches.starts[k]], last = next[patches.starts[k + 1]];
      if (first == last) continue;
      weights.groups.push_back(
          {.cell = patches.cells[patches.starts[k]], .body = b, .first = first, .last = last});
    }
    for (std::int32_t p = begin; p < end; ++p) weights.point[next[place[points.cell[p]]]++] = p;
    weights.body_groups.push_back(static_cast<std::int32_t>(weights.groups.size()));
  }
}

// Numbers of the cell's nodes within the group, which gets those that it does not have yet.
template <int dim>
void add_nodes(const CellList& nodes, CellGroup& group, PointWeights<dim>& weights,
               std::uint8_t* local) {
  auto& all = weights.group_nodes;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const auto first = all.begin() + group.first_node;
    const auto found = std::find(first, all.end(), nodes[i]);
    local[i] = static_cast<std::uint8_t>(found - first);
    if (found == all.end()) all.push_back(nodes[i]);
  }
  group.num_nodes = static_cast<std::int32_t>(all.size()) - group.first_node;
  require(group.num_nodes <= max_group_nodes<dim>, "mpm_solver: a patch of cells is too large");
}

}  // namespace

template <int dim>
void evaluate_patch_basis(const BackgroundGrid<dim>& grid, const MaterialPoints<dim>& points,
                          PointWeights<dim>& weights) {
  const int n = grid.nodes_per_cell();
  weights.constant_gradient = false;
  weights.whole_cells = false;
  weights.num_capped = 0;
  sort_by_patch(grid.patches, points, weights);
  weights.resize(points.size(), n);

  Vector<dim> corners[max_cell_nodes];
  ShapeValues<dim> shape;
  std::uint8_t local[max_cell_nodes];
  for (CellGroup& group : weights.groups) {
    group.first_node = static_cast<std::int32_t>(weights.group_nodes.size());
    std::int32_t cell = -1;
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const std::int32_t p = weights.point[e];
      if (points.cell[p] != cell) {
        cell = points.cell[p];
        add_nodes(grid.cell(cell), group, weights, local);
        grid.corners(cell, corners);
      }
      shape_functions<dim>(grid.cell_type, grid.local_coordinates(cell, points.x[p]), shape);
      map_gradients<dim>(grid.cell_type, corners, shape);
      const std::int32_t row = weights.starts[e];
      std::copy_n(local, n, weights.local.begin() + row);
      std::copy_n(shape.N, n, weights.N.begin() + row);
      std::copy_n(shape.dN, n, weights.grad_N.begin() + row);
    }
  }
}

template void evaluate_patch_basis<2>(const BackgroundGrid<2>&, const MaterialPoints<2>&,
                                      PointWeights<2>&);
template void evaluate_patch_basis<3>(const BackgroundGrid<3>&, const MaterialPoints<3>&,
                                      PointWeights<3>&);

}  // namespace gabion::mpm
