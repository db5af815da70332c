// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/grid/basis.hpp"

#include <algorithm>
#include <span>

#include "common/base/require.hpp"
#include "common/mechanics/elements/shape_functions.hpp"
#include "mpm_solver/grid/box_basis.hpp"
#include "mpm_solver/grid/patch_basis.hpp"
#include "mpm_solver/grid/soil_border.hpp"
#include "mpm_solver/grid/sparse_list.hpp"

namespace gabion::mpm {

template <int dim>
std::vector<std::int32_t> find_cells(const BackgroundGrid<dim>& grid, MaterialPoints<dim>& points) {
  std::vector<std::int32_t> outside;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    points.cell[p] = grid.locate(points.x[p], points.cell[p]);
    if (points.cell[p] < 0) outside.push_back(p);
  }
  return outside;
}

namespace {

// Sort the points of each body by cell (counting sort, stable) and list the groups.
template <int dim>
void sort_by_cell(std::int32_t num_cells, const MaterialPoints<dim>& points,
                  PointWeights<dim>& weights) {
  weights.point.resize(points.size());
  weights.groups.clear();
  weights.body_groups.assign(1, 0);
  static thread_local SparseList<std::int32_t> next;  // of each cell: its points, then an entry
  for (std::int32_t b = 0; b < points.num_bodies(); ++b) {
    next.assign(num_cells, 0);
    const std::int32_t begin = points.body_starts[b];
    const std::int32_t end = points.body_starts[b + 1];
    std::int32_t* at = nullptr;  // of the last cell: points follow each other in cells
    for (std::int32_t p = begin, cell = -1; p < end; ++p) {
      if (points.cell[p] != cell) at = &next.at(cell = points.cell[p]);
      ++*at;
    }
    std::int32_t last = begin;
    next.for_each([&](std::size_t cell, std::int32_t& count) {
      const std::int32_t first = last;
      last += count;
      weights.groups.push_back(
          {.cell = static_cast<std::int32_t>(cell), .body = b, .first = first, .last = last});
      count = first;
    });
    for (std::int32_t p = begin, cell = -1; p < end; ++p) {
      if (points.cell[p] != cell) at = &next.at(cell = points.cell[p]);
      weights.point[(*at)++] = p;
    }
    weights.body_groups.push_back(static_cast<std::int32_t>(weights.groups.size()));
  }
}

// Values and gradients in a rectangle or brick, nodes in the order of CellType.
// @param low, over_size  its lowest corner, and 1 / edge along each axis
template <int dim>
void brick_functions(const Vector<dim>& x, const Vector<dim>& low, const Vector<dim>& over_size,
                     double* N, Vector<dim>* grad) {
  constexpr bool upper[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  double value[dim][2];
  for (int d = 0; d < dim; ++d) {
    value[d][1] = (x[d] - low[d]) * over_size[d];
    value[d][0] = 1 - value[d][1];
  }
  for (int i = 0; i < (1 << dim); ++i) {
    N[i] = 1;
    for (int d = 0; d < dim; ++d) {
      N[i] *= value[d][upper[i][d]];
      grad[i][d] = upper[i][d] ? over_size[d] : -over_size[d];
      for (int e = 0; e < dim; ++e) {
        if (e != d) grad[i][d] *= value[e][upper[i][e]];
      }
    }
  }
}

// Room for the values, whose nodes are all those of the cell in their order.
template <int dim>
void make_room(std::int32_t num_points, int n, PointWeights<dim>& weights) {
  const std::size_t size = static_cast<std::size_t>(num_points) * n;
  const bool same = weights.whole_cells && weights.local.size() == size;
  weights.whole_cells = true;
  weights.group_nodes.clear();
  if (same) return;
  weights.resize(num_points, n);
  for (std::size_t k = 0; k < size; ++k) weights.local[k] = static_cast<std::uint8_t>(k % n);
}

template <int dim>
void evaluate_linear_basis(const BackgroundGrid<dim>& grid, const MaterialPoints<dim>& points,
                           PointWeights<dim>& weights) {
  const int n = grid.nodes_per_cell();
  weights.constant_gradient = grid.is_simplex();
  weights.num_capped = 0;
  make_room(points.size(), n, weights);

  Vector<dim> corners[max_cell_nodes];
  ShapeValues<dim> shape;
  for (CellGroup& group : weights.groups) {
    const CellList nodes = grid.cell(group.cell);
    group.first_node = static_cast<std::int32_t>(weights.group_nodes.size());
    group.num_nodes = n;
    weights.group_nodes.insert(weights.group_nodes.end(), nodes.begin(), nodes.end());
    if (grid.box) {
      const Vector<dim> low = grid.node(nodes[0]);
      const Vector<dim> over_size = grid.box->spacing.cwiseInverse();
      for (std::int32_t e = group.first; e < group.last; ++e) {
        const std::int32_t row = weights.starts[e];
        brick_functions<dim>(points.x[weights.point[e]], low, over_size, &weights.N[row],
                             &weights.grad_N[row]);
      }
      continue;
    }
    grid.corners(group.cell, corners);
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const Vector<dim> xi = grid.local_coordinates(group.cell, points.x[weights.point[e]]);
      shape_functions<dim>(grid.cell_type, xi, shape);
      const std::int32_t row = weights.starts[e];
      std::copy_n(shape.N, n, weights.N.begin() + row);
      if (e == group.first || !weights.constant_gradient) {
        map_gradients<dim>(grid.cell_type, corners, shape);
        std::copy_n(shape.dN, n, weights.grad_N.begin() + row);
      }
    }
  }
}

}  // namespace

template <int dim>
void evaluate_basis(const BackgroundGrid<dim>& grid, const MaterialPoints<dim>& points,
                    PointWeights<dim>& weights, const SoilBorder<dim>* border) {
  require(grid.splits_border == (border != nullptr), "mpm_solver: the border of the soil");
  if (grid.patches.size() > 0) {
    evaluate_patch_basis(grid, points, weights);
  } else {
    sort_by_cell(grid.num_cells(), points, weights);
    if (border) split_groups(*border, *grid.box, points, weights);
    if (grid.basis == Basis::linear) {
      evaluate_linear_basis(grid, points, weights);
    } else {
      evaluate_box_basis(grid, points, weights);
    }
  }
  weights.num_fields = 1;
  weights.volume.clear();
  for (const std::int32_t p : weights.point) weights.volume.push_back(points.V0[p]);
}

template std::vector<std::int32_t> find_cells<2>(const BackgroundGrid<2>&, MaterialPoints<2>&);
template std::vector<std::int32_t> find_cells<3>(const BackgroundGrid<3>&, MaterialPoints<3>&);
template void evaluate_basis<2>(const BackgroundGrid<2>&, const MaterialPoints<2>&,
                                PointWeights<2>&, const SoilBorder<2>*);
template void evaluate_basis<3>(const BackgroundGrid<3>&, const MaterialPoints<3>&,
                                PointWeights<3>&, const SoilBorder<3>*);

}  // namespace gabion::mpm
