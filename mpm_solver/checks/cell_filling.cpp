// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/checks/cell_filling.hpp"

#include <algorithm>
#include <cmath>

#include "mpm_solver/grid/sparse_list.hpp"
#include "mpm_solver/stress/cell_quadrature.hpp"

namespace gabion::mpm {

namespace {

// Volume of the points in each cell over that of the cell.
template <int dim>
SparseList<double> fillings(const BackgroundGrid<dim>& grid,
                            const std::vector<PointLayout<dim>>& layouts) {
  SparseList<double> filled(grid.num_cells(), 0);
  for (const PointLayout<dim>& layout : layouts) {
    MaterialPoints<dim> points;
    lay_points<dim>(layout, 1, {}, points);
    std::int32_t cell = 0;
    for (std::int32_t p = 0; p < points.size(); ++p) {
      cell = grid.locate(points.x[p], std::max(cell, 0));
      if (cell >= 0) filled.at(cell) += points.V0[p] / cell_volume(grid, cell);
    }
  }
  return filled;
}

// 1 for the nodes of cells that are filled by less than `least_filling`.
template <int dim>
SparseList<char> nodes_at_border(const BackgroundGrid<dim>& grid,
                                 const SparseList<double>& filled) {
  SparseList<char> at_border(grid.num_nodes_total(), 0);
  for (std::int32_t c = 0; c < grid.num_cells(); ++c) {
    if (filled[c] >= least_filling) continue;
    for (const std::int32_t node : grid.cell(c)) at_border.at(node) = 1;
  }
  return at_border;
}

}  // namespace

template <int dim>
double uneven_filling(const BackgroundGrid<dim>& grid,
                      const std::vector<PointLayout<dim>>& layouts) {
  SparseList<double> filled = fillings(grid, layouts);
  const SparseList<char> at_border = nodes_at_border(grid, filled);
  double largest = 0;
  filled.for_each([&](std::size_t cell, double share) {
    const CellList nodes = grid.cell(static_cast<std::int32_t>(cell));
    const auto open = [&](std::int32_t node) { return at_border[node] != 0; };
    if (std::any_of(nodes.begin(), nodes.end(), open)) return;
    largest = std::max(largest, std::abs(share - 1));
  });
  return largest;
}

template double uneven_filling<2>(const BackgroundGrid<2>&, const std::vector<PointLayout<2>>&);
template double uneven_filling<3>(const BackgroundGrid<3>&, const std::vector<PointLayout<3>>&);

}  // namespace gabion::mpm
