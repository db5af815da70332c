// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/grid/background_grid.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "common/base/require.hpp"
#include "common/mechanics/elements/cell_facets.hpp"

namespace gabion::mpm {

const char* basis_name(Basis basis) {
  return basis == Basis::linear ? "linear" : basis == Basis::gimp ? "gimp" : "bspline";
}

template <int dim>
BackgroundGrid<dim>::BackgroundGrid(const BoxGrid<dim>& box_, Basis basis_)
    : box(box_), facet_groups(box_.sides()), basis(basis_) {}

template <int dim>
BackgroundGrid<dim>::BackgroundGrid(Mesh<dim> mesh, Basis basis_)
    : cell_type(mesh.cell_type),
      box(box_grid(mesh)),
      facet_groups(std::move(mesh.facet_groups)),
      basis(basis_) {
  require(basis == Basis::linear || box,
          "mpm_solver: a basis other than linear needs equal cells in rows");
  if (!box) stored = std::make_shared<const StoredCells<dim>>(std::move(mesh));
}

template <int dim>
void BackgroundGrid<dim>::corners(std::int32_t c, Vector<dim>* x) const {
  const CellList nodes = cell(c);
  for (std::size_t i = 0; i < nodes.size(); ++i) x[i] = node(nodes[i]);
}

template <int dim>
CellList BackgroundGrid<dim>::neighbours(std::int32_t c) const {
  if (!box) return CellList(stored->locator.neighbours(c));
  const auto along_axes = box->neighbours(c);
  std::array<std::int32_t, 2 * dim> result;
  for (int k = 0; k < 2 * dim; ++k) result[brick_facet(dim, k / 2, k % 2)] = along_axes[k];
  return CellList(result);
}

template <int dim>
CellList BackgroundGrid<dim>::facet(std::int32_t c, int f) const {
  const CellList nodes = cell(c);
  std::vector<std::int32_t> result;
  for (const int a : facet_nodes(cell_type, f)) result.push_back(nodes[a]);
  return CellList(result);
}

template <int dim>
Vector<dim> BackgroundGrid<dim>::local_coordinates(std::int32_t c, const Vector<dim>& x) const {
  if (!box) return stored->locator.local_coordinates(c, x);
  const Vector<dim> at = box->cell_index(c).template cast<double>();
  return 2 * (box->lattice_position(x) - at) - Vector<dim>::Ones();
}

template <int dim>
Vector<dim> BackgroundGrid<dim>::home(std::int32_t c) const {
  if (box) {  // opposite corners
    const auto nodes = box->cell_nodes(c);
    return 0.5 * (box->node_position(nodes[0]) + box->node_position(nodes[dim == 2 ? 2 : 6]));
  }
  const CellList nodes = cell(first_of_patch(c));
  Vector<dim> sum = Vector<dim>::Zero();
  for (const std::int32_t n : nodes) sum += node(n);
  return sum / static_cast<double>(nodes.size());
}

template <int dim>
double shortest_edge(const BackgroundGrid<dim>& grid, std::int32_t cell) {
  if (grid.box) return grid.box->shortest_edge(cell);
  Vector<dim> x[max_cell_nodes];
  grid.corners(cell, x);
  double shortest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < grid.nodes_per_cell(); ++i) {
    for (int j = 0; j < i; ++j) shortest = std::min(shortest, (x[i] - x[j]).norm());
  }
  return shortest;
}

template <int dim>
double mean_cell_size(const BackgroundGrid<dim>& grid) {
  double sum = 0;
  for (std::int32_t c = 0; c < grid.num_cells(); ++c) sum += shortest_edge(grid, c);
  return sum / grid.num_cells();
}

template <int dim>
Eigen::AlignedBox<double, dim> bounding_box(const BackgroundGrid<dim>& grid) {
  if (grid.box) return {grid.box->low, grid.box->high};
  Eigen::AlignedBox<double, dim> around;
  for (const Vector<dim>& x : grid.stored->mesh.nodes) around.extend(x);
  return around;
}

template <int dim>
double cell_volume(const BackgroundGrid<dim>& grid, std::int32_t cell) {
  if (grid.box) return grid.box->spacing.prod();
  Vector<dim> x[max_cell_nodes];
  grid.corners(cell, x);
  return cell_volume<dim>(grid.cell_type,
                          std::span(x, static_cast<std::size_t>(grid.nodes_per_cell())));
}

template <int dim>
std::vector<FacetGeometry<dim>> facet_geometry(const BackgroundGrid<dim>& grid,
                                               std::span<const std::int32_t> facets) {
  std::vector<Vector<dim>> x;
  for (const std::int32_t node : facets) x.push_back(grid.node(node));
  std::vector<std::int32_t> numbers(x.size());
  std::iota(numbers.begin(), numbers.end(), 0);
  return facet_geometry<dim>(x, facet_type(grid.cell_type), numbers);
}

template struct BackgroundGrid<2>;
template struct BackgroundGrid<3>;
template double shortest_edge<2>(const BackgroundGrid<2>&, std::int32_t);
template double shortest_edge<3>(const BackgroundGrid<3>&, std::int32_t);
template double mean_cell_size<2>(const BackgroundGrid<2>&);
template double mean_cell_size<3>(const BackgroundGrid<3>&);
template Eigen::AlignedBox<double, 2> bounding_box<2>(const BackgroundGrid<2>&);
template Eigen::AlignedBox<double, 3> bounding_box<3>(const BackgroundGrid<3>&);
template double cell_volume<2>(const BackgroundGrid<2>&, std::int32_t);
template double cell_volume<3>(const BackgroundGrid<3>&, std::int32_t);
template std::vector<FacetGeometry<2>> facet_geometry<2>(const BackgroundGrid<2>&,
                                                         std::span<const std::int32_t>);
template std::vector<FacetGeometry<3>> facet_geometry<3>(const BackgroundGrid<3>&,
                                                         std::span<const std::int32_t>);

}  // namespace gabion::mpm
