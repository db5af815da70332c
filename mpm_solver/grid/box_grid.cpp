// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/grid/box_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gabion::mpm {

namespace {

// Steps from the first corner of a quad or hex to the others, in Gmsh's order.
constexpr int corner_steps[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                    {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};

template <int dim>
double largest_coordinate(const Mesh<dim>& mesh) {
  double largest = 0;
  for (const auto& x : mesh.nodes) largest = std::max(largest, x.cwiseAbs().maxCoeff());
  return largest;
}

template <int dim>
bool has_node_order(const Mesh<dim>& mesh, const BoxGrid<dim>& grid) {
  typename BoxGrid<dim>::Index at = BoxGrid<dim>::Index::Zero();
  for (const auto& x : mesh.nodes) {
    const Vector<dim> offset = grid.lattice_position(x) - at.template cast<double>();
    if (!((offset.cwiseAbs() - grid.tolerance).maxCoeff() <= 0)) return false;
    for (int d = 0; d < dim; ++d) {
      if (++at[d] <= grid.num_cells[d]) break;
      at[d] = 0;
    }
  }
  return true;
}

template <int dim>
bool has_cell_order(const Mesh<dim>& mesh, const BoxGrid<dim>& grid) {
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
    const auto index = grid.cell_index(c);
    const auto cell = mesh.cell(c);
    for (std::size_t a = 0; a < cell.size(); ++a) {
      auto at = index;
      for (int d = 0; d < dim; ++d) at[d] += corner_steps[a][d];
      if (cell[a] != grid.node(at)) return false;
    }
  }
  return true;
}

}  // namespace

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
typename BoxGrid<dim>::Index BoxGrid<dim>::cell_index(std::int32_t cell) const {
  Index at;
  for (int d = 0; d < dim; ++d) {
    at[d] = cell % num_cells[d];
    cell /= num_cells[d];
  }
  return at;
}

template <int dim>
std::int32_t BoxGrid<dim>::node(const Index& at) const {
  std::int32_t number = 0;
  for (int d = dim - 1; d >= 0; --d) number = number * (num_cells[d] + 1) + at[d];
  return number;
}

template <int dim>
std::optional<BoxGrid<dim>> box_grid(const Mesh<dim>& mesh) {
  if (mesh.cell_type != (dim == 2 ? CellType::quad4 : CellType::hex8) || mesh.num_cells() == 0) {
    return std::nullopt;
  }
  // The opposite corners of the mesh and of its first cell give the rows.
  BoxGrid<dim> grid;
  grid.low = mesh.nodes.front();
  const Vector<dim> size = mesh.nodes.back() - grid.low;
  const Vector<dim> first = mesh.nodes[mesh.cell(0)[dim == 2 ? 2 : 6]] - grid.low;
  std::int64_t num_cells = 1;
  for (int d = 0; d < dim; ++d) {
    const double count = std::round(size[d] / first[d]);
    if (!(first[d] > 0 && count >= 1 && count <= mesh.num_cells())) return std::nullopt;
    grid.num_cells[d] = static_cast<int>(count);
    grid.spacing[d] = size[d] / count;
    num_cells *= grid.num_cells[d];
    if (num_cells > mesh.num_cells()) return std::nullopt;
  }
  grid.tolerance = (16 * std::numeric_limits<double>::epsilon() * largest_coordinate(mesh)) *
                       grid.spacing.cwiseInverse() +
                   Vector<dim>::Constant(1e-12);
  const bool fits =
      num_cells == mesh.num_cells() &&
      (grid.num_cells.template cast<std::int64_t>().array() + 1).prod() == mesh.num_nodes_total();
  if (!fits || !has_node_order(mesh, grid) || !has_cell_order(mesh, grid)) return std::nullopt;
  return grid;
}

template struct BoxGrid<2>;
template struct BoxGrid<3>;
template std::optional<BoxGrid<2>> box_grid(const Mesh<2>&);
template std::optional<BoxGrid<3>> box_grid(const Mesh<3>&);

}  // namespace gabion::mpm
