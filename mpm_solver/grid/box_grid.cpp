// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/grid/box_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/require.hpp"
#include "common/mechanics/elements/cell_facets.hpp"
#include "common/mechanics/mesh/box_lattice.hpp"

namespace gabion::mpm {

namespace {

template <int dim>
double coordinate(const BoxGrid<dim>& grid, int axis, int at) {
  return lattice_coordinate(grid.low[axis], grid.high[axis], at, grid.num_cells[axis]);
}

// The cells from one place to another, ascending.
template <int dim>
std::vector<std::int32_t> cells_between(const LatticeIndex<dim>& first,
                                        const LatticeIndex<dim>& last,
                                        const LatticeIndex<dim>& num_cells) {
  std::vector<std::int32_t> cells(1, 0);
  for (int d = dim - 1; d >= 0; --d) {
    std::vector<std::int32_t> rows;
    for (const std::int32_t cell : cells) {
      for (int at = first[d]; at <= last[d]; ++at) rows.push_back(cell * num_cells[d] + at);
    }
    cells = std::move(rows);
  }
  return cells;
}

template <int dim>
bool has_node_positions(const Mesh<dim>& mesh, const BoxGrid<dim>& grid) {
  for (std::int32_t n = 0; n < mesh.num_nodes_total(); ++n) {
    const Vector<dim> offset =
        grid.lattice_position(mesh.nodes[n]) - grid.lattice_position(grid.node_position(n));
    if (!((offset.cwiseAbs() - grid.tolerance).maxCoeff() <= 0)) return false;
  }
  return true;
}

template <int dim>
bool has_cell_order(const Mesh<dim>& mesh, const BoxGrid<dim>& grid) {
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
    const auto nodes = grid.cell_nodes(c);
    if (!std::equal(nodes.begin(), nodes.end(), mesh.cell(c).begin())) return false;
  }
  return true;
}

}  // namespace

template <int dim>
BoxGrid<dim>::BoxGrid(const Vector<dim>& low_, const Vector<dim>& high_, const Index& num_cells_)
    : low(low_), high(high_), num_cells(num_cells_) {
  std::int64_t num_nodes = 1;
  for (int d = 0; d < dim; ++d) {
    require<ConfigError>(low[d] < high[d],
                         "box, axis {}: found low {} and high {}, allowed: low < high", d, low[d],
                         high[d]);
    require<ConfigError>(num_cells[d] >= 1, "box, axis {}: found {} cells, allowed: at least 1", d,
                         num_cells[d]);
    num_nodes *= std::int64_t{num_cells[d]} + 1;
    require<ConfigError>(num_nodes <= std::numeric_limits<std::int32_t>::max(),
                         "box: found more cells than 32-bit indices can count");
    spacing[d] = (high[d] - low[d]) / num_cells[d];
  }
  const double largest = std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff());
  tolerance = (16 * std::numeric_limits<double>::epsilon() * largest) * spacing.cwiseInverse() +
              Vector<dim>::Constant(1e-12);
  constexpr double most = 1e-2;  // of a cell
  require<ConfigError>(
      tolerance.maxCoeff() < most,
      "box: found coordinates up to {} beside cells of {} m, allowed: cells that the digits of the "
      "coordinates resolve to {} of their size",
      largest, spacing.minCoeff(), most);
}

template <int dim>
std::int32_t BoxGrid<dim>::locate(const Vector<dim>& x) const {
  const Vector<dim> t = lattice_position(x);
  std::int32_t cell = 0;
  for (int d = dim - 1; d >= 0; --d) {
    // Written so that NaN is outside.
    if (!(t[d] >= -tolerance[d] && t[d] <= num_cells[d] + tolerance[d])) return -1;
    const int at = static_cast<int>(std::ceil(t[d] - tolerance[d])) - 1;
    cell = cell * num_cells[d] + std::max(at, 0);
  }
  return cell;
}

template <int dim>
std::vector<std::int32_t> BoxGrid<dim>::cells_at(const Vector<dim>& x) const {
  const Vector<dim> t = lattice_position(x);
  Index first, last;
  for (int d = 0; d < dim; ++d) {
    // Written so that NaN is outside.
    if (!(t[d] >= -tolerance[d] && t[d] <= num_cells[d] + tolerance[d])) return {};
    first[d] = std::max(static_cast<int>(std::ceil(t[d] - tolerance[d])) - 1, 0);
    last[d] = std::min(static_cast<int>(std::floor(t[d] + tolerance[d])), num_cells[d] - 1);
  }
  return cells_between<dim>(first, last, num_cells);
}

template <int dim>
typename BoxGrid<dim>::Index BoxGrid<dim>::cell_index(std::int32_t cell) const {
  return lattice_index<dim>(cell, num_cells);
}

template <int dim>
std::int32_t BoxGrid<dim>::node(const Index& at) const {
  return lattice_node<dim>(at, num_cells);
}

template <int dim>
Vector<dim> BoxGrid<dim>::node_position(std::int32_t node) const {
  const Index at = lattice_index<dim>(node, num_cells + Index::Ones());
  Vector<dim> x;
  for (int d = 0; d < dim; ++d) x[d] = coordinate(*this, d, at[d]);
  return x;
}

template <int dim>
typename BoxGrid<dim>::CellNodes BoxGrid<dim>::cell_nodes(std::int32_t cell) const {
  return brick_nodes<dim>(cell_index(cell), num_cells);
}

template <int dim>
std::array<std::int32_t, 2 * dim> BoxGrid<dim>::neighbours(std::int32_t cell) const {
  std::array<std::int32_t, 2 * dim> result;
  const Index at = cell_index(cell);
  std::int32_t stride = 1;
  for (int d = 0; d < dim; ++d) {
    result[2 * d] = at[d] > 0 ? cell - stride : -1;
    result[2 * d + 1] = at[d] + 1 < num_cells[d] ? cell + stride : -1;
    stride *= num_cells[d];
  }
  return result;
}

template <int dim>
std::vector<std::int32_t> BoxGrid<dim>::cells_around(std::int32_t node) const {
  const Index at = lattice_index<dim>(node, num_cells + Index::Ones());
  return cells_between<dim>((at - Index::Ones()).cwiseMax(0),
                            at.cwiseMin(num_cells - Index::Ones()), num_cells);
}

template <int dim>
int BoxGrid<dim>::num_cells_around(std::int32_t node) const {
  const Index at = lattice_index<dim>(node, num_cells + Index::Ones());
  int count = 1;
  for (int d = 0; d < dim; ++d) count *= (at[d] > 0) + (at[d] < num_cells[d]);
  return count;
}

template <int dim>
bool BoxGrid<dim>::at_side(std::int32_t cell) const {
  const Index at = cell_index(cell);
  return at.minCoeff() == 0 || (num_cells - at).minCoeff() == 1;
}

template <int dim>
double BoxGrid<dim>::shortest_edge(std::int32_t cell) const {
  const Index at = cell_index(cell);
  double shortest = std::numeric_limits<double>::infinity();
  for (int d = 0; d < dim; ++d) {
    shortest = std::min(shortest, coordinate(*this, d, at[d] + 1) - coordinate(*this, d, at[d]));
  }
  return shortest;
}

template <int dim>
FacetGroups BoxGrid<dim>::sides() const {
  FacetGroups groups;
  for (int side = 0; side < 2 * dim; ++side) {
    const int axis = side / 2, end = side % 2;
    const auto corners = facet_nodes(cell_type, brick_facet(dim, axis, end));
    auto& facets = groups[box_side_name(dim, axis, end)];
    Index layer = num_cells;
    layer[axis] = 1;
    for (std::int32_t k = 0; k < layer.prod(); ++k) {
      Index at = lattice_index<dim>(k, layer);
      if (end == 1) at[axis] = num_cells[axis] - 1;
      for (const int a : corners) {
        Index corner = at;
        for (int d = 0; d < dim; ++d) corner[d] += brick_corners[a][d];
        facets.push_back(node(corner));
      }
    }
  }
  return groups;
}

template <int dim>
std::optional<BoxGrid<dim>> box_grid(const Mesh<dim>& mesh) {
  if (mesh.cell_type != BoxGrid<dim>::cell_type || mesh.num_cells() == 0) return std::nullopt;
  // The opposite corners of the mesh and of its first cell give the rows.
  const Vector<dim> low = mesh.nodes.front(), high = mesh.nodes.back();
  const Vector<dim> first = mesh.nodes[mesh.cell(0)[dim == 2 ? 2 : 6]] - low;
  typename BoxGrid<dim>::Index num_cells;
  std::int64_t total = 1;
  for (int d = 0; d < dim; ++d) {
    const double count = std::round((high[d] - low[d]) / first[d]);
    if (!(first[d] > 0 && count >= 1 && count <= mesh.num_cells())) return std::nullopt;
    num_cells[d] = static_cast<int>(count);
    total *= num_cells[d];
    if (total > mesh.num_cells()) return std::nullopt;
  }
  const bool fits =
      total == mesh.num_cells() &&
      (num_cells.template cast<std::int64_t>().array() + 1).prod() == mesh.num_nodes_total();
  if (!fits) return std::nullopt;
  const BoxGrid<dim> grid(low, high, num_cells);
  if (!has_node_positions(mesh, grid) || !has_cell_order(mesh, grid)) return std::nullopt;
  return grid;
}

template struct BoxGrid<2>;
template struct BoxGrid<3>;
template std::optional<BoxGrid<2>> box_grid(const Mesh<2>&);
template std::optional<BoxGrid<3>> box_grid(const Mesh<3>&);

}  // namespace gabion::mpm
