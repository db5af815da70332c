// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/grid/basis.hpp"

#include <algorithm>
#include <numeric>

#include "common/base/require.hpp"
#include "common/mechanics/elements/shape_functions.hpp"
#include "mpm_solver/grid/box_basis.hpp"
#include "mpm_solver/grid/patch_basis.hpp"
#include "mpm_solver/grid/soil_border.hpp"

namespace gabion::mpm {

const char* basis_name(Basis basis) {
  return basis == Basis::linear ? "linear" : basis == Basis::gimp ? "gimp" : "bspline";
}

template <int dim>
BackgroundGrid<dim>::BackgroundGrid(Mesh<dim> mesh_, Basis basis_)
    : mesh(std::move(mesh_)), locator(mesh), box(box_grid(mesh)), basis(basis_) {
  require(basis == Basis::linear || box,
          "mpm_solver: a basis other than linear needs equal cells in rows");
}

template <int dim>
Vector<dim> BackgroundGrid<dim>::home(std::int32_t cell) const {
  const auto nodes = mesh.cell(first_of_patch(cell));
  Vector<dim> sum = Vector<dim>::Zero();
  for (const std::int32_t node : nodes) sum += mesh.nodes[node];
  return sum / static_cast<double>(nodes.size());
}

template <int dim>
double shortest_edge(const Mesh<dim>& mesh, std::int32_t cell) {
  const auto nodes = mesh.cell(cell);
  double shortest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      shortest = std::min(shortest, (mesh.nodes[nodes[i]] - mesh.nodes[nodes[j]]).norm());
    }
  }
  return shortest;
}

template <int dim>
double mean_cell_size(const Mesh<dim>& mesh) {
  double sum = 0;
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) sum += shortest_edge(mesh, c);
  return sum / mesh.num_cells();
}

template <int dim>
std::int32_t cell_of(const BackgroundGrid<dim>& grid, const Vector<dim>& x, std::int32_t hint) {
  return grid.box ? grid.box->locate(x) : grid.locator.locate(x, hint);
}

template <int dim>
std::vector<std::int32_t> find_cells(const BackgroundGrid<dim>& grid, MaterialPoints<dim>& points) {
  std::vector<std::int32_t> outside;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    points.cell[p] = cell_of(grid, points.x[p], points.cell[p]);
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
  static thread_local std::vector<std::int32_t> starts;
  for (std::int32_t b = 0; b < points.num_bodies(); ++b) {
    starts.assign(num_cells + 1, 0);
    const std::int32_t begin = points.body_starts[b];
    const std::int32_t end = points.body_starts[b + 1];
    for (std::int32_t p = begin; p < end; ++p) ++starts[points.cell[p] + 1];
    std::partial_sum(starts.begin(), starts.end(), starts.begin());
    for (std::int32_t c = 0; c < num_cells; ++c) {
      if (starts[c] == starts[c + 1]) continue;
      weights.groups.push_back(
          {.cell = c, .body = b, .first = begin + starts[c], .last = begin + starts[c + 1]});
    }
    for (std::int32_t p = begin; p < end; ++p) {
      weights.point[begin + starts[points.cell[p]]++] = p;
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
  const Mesh<dim>& mesh = grid.mesh;
  const int n = mesh.nodes_per_cell();
  weights.constant_gradient = mesh.cell_type == CellType::tri3 || mesh.cell_type == CellType::tet4;
  weights.num_capped = 0;
  make_room(points.size(), n, weights);

  Vector<dim> corners[max_cell_nodes];
  ShapeValues<dim> shape;
  for (CellGroup& group : weights.groups) {
    const auto nodes = mesh.cell(group.cell);
    group.first_node = static_cast<std::int32_t>(weights.group_nodes.size());
    group.num_nodes = n;
    weights.group_nodes.insert(weights.group_nodes.end(), nodes.begin(), nodes.end());
    if (grid.box) {
      const Vector<dim> over_size = grid.box->spacing.cwiseInverse();
      for (std::int32_t e = group.first; e < group.last; ++e) {
        const std::int32_t row = weights.starts[e];
        brick_functions<dim>(points.x[weights.point[e]], mesh.nodes[nodes[0]], over_size,
                             &weights.N[row], &weights.grad_N[row]);
      }
      continue;
    }
    for (int i = 0; i < n; ++i) corners[i] = mesh.nodes[nodes[i]];
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const Vector<dim> xi = grid.locator.local_coordinates(group.cell, points.x[weights.point[e]]);
      shape_functions<dim>(mesh.cell_type, xi, shape);
      const std::int32_t row = weights.starts[e];
      std::copy_n(shape.N, n, weights.N.begin() + row);
      if (e == group.first || !weights.constant_gradient) {
        map_gradients<dim>(mesh.cell_type, corners, shape);
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
    return;
  }
  sort_by_cell(grid.mesh.num_cells(), points, weights);
  if (border) split_groups(*border, *grid.box, points, weights);
  if (grid.basis == Basis::linear) {
    evaluate_linear_basis(grid, points, weights);
  } else {
    evaluate_box_basis(grid, points, weights);
  }
}

template double shortest_edge<2>(const Mesh<2>&, std::int32_t);
template double shortest_edge<3>(const Mesh<3>&, std::int32_t);
template double mean_cell_size<2>(const Mesh<2>&);
template double mean_cell_size<3>(const Mesh<3>&);
template struct BackgroundGrid<2>;
template struct BackgroundGrid<3>;
template std::int32_t cell_of<2>(const BackgroundGrid<2>&, const Vector<2>&, std::int32_t);
template std::int32_t cell_of<3>(const BackgroundGrid<3>&, const Vector<3>&, std::int32_t);
template std::vector<std::int32_t> find_cells<2>(const BackgroundGrid<2>&, MaterialPoints<2>&);
template std::vector<std::int32_t> find_cells<3>(const BackgroundGrid<3>&, MaterialPoints<3>&);
template void evaluate_basis<2>(const BackgroundGrid<2>&, const MaterialPoints<2>&,
                                PointWeights<2>&, const SoilBorder<2>*);
template void evaluate_basis<3>(const BackgroundGrid<3>&, const MaterialPoints<3>&,
                                PointWeights<3>&, const SoilBorder<3>*);

}  // namespace gabion::mpm
