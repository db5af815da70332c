// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <array>

#include "common/base/require.hpp"
#include "common/mechanics/elements/cell_facets.hpp"
#include "common/mechanics/mesh/box_lattice.hpp"
#include "common/mechanics/mesh/mesh.hpp"

namespace gabion {

namespace {

template <int n>
using Pieces = std::vector<std::array<int, n>>;

// How a quad or hex (local nodes in Gmsh's order) is cut. Even and odd pieces meet each other's
// diagonals, so a chess board of them is conforming; so is a lattice of the even ones of tri3 and
// of six tetrahedra (Kuhn), whose opposite faces carry parallel diagonals.
const Pieces<3> even_triangles = {{0, 1, 2}, {0, 2, 3}};
const Pieces<3> odd_triangles = {{0, 1, 3}, {1, 2, 3}};
const Pieces<4> six_tetrahedra = {{0, 1, 2, 6}, {0, 2, 3, 6}, {0, 3, 7, 6},
                                  {0, 7, 4, 6}, {0, 4, 5, 6}, {0, 5, 1, 6}};
const Pieces<4> even_tetrahedra = {
    {1, 3, 4, 6}, {0, 1, 3, 4}, {2, 3, 1, 6}, {5, 4, 6, 1}, {7, 6, 4, 3}};
const Pieces<4> odd_tetrahedra = {
    {0, 2, 7, 5}, {1, 2, 0, 5}, {3, 0, 2, 7}, {4, 7, 5, 0}, {6, 5, 7, 2}};

template <int n, std::size_t m>
void add_pieces(const Pieces<n>& pieces, const std::array<std::int32_t, m>& brick,
                std::vector<std::int32_t>& cells) {
  for (const auto& piece : pieces) {
    for (int a : piece) cells.push_back(brick[a]);
  }
}

template <int dim>
void check_box(const Vector<dim>& low, const Vector<dim>& high, const LatticeIndex<dim>& num_cells,
               CellType type) {
  require<ConfigError>(dimension(type) == dim,
                       "box mesh of dimension {}: found cell type {}, allowed: {}", dim, name(type),
                       dim == 2 ? "tri3, quad4" : "tet4, hex8");
  std::int64_t num_nodes_total = 1;
  for (int i = 0; i < dim; ++i) {
    require<ConfigError>(low[i] < high[i],
                         "box mesh, axis {}: found low {} and high {}, allowed: low < high", i,
                         low[i], high[i]);
    require<ConfigError>(num_cells[i] >= 1,
                         "box mesh, axis {}: found {} cells, allowed: at least 1", i, num_cells[i]);
    num_nodes_total *= std::int64_t{num_cells[i]} + 1;
    require<ConfigError>(num_nodes_total < (std::int64_t{1} << 31) / 48,
                         "box mesh: found more cells than 32-bit indices can count");
  }
}

/// Facets of cells that lie in a side of the box, told by the lattice positions of their nodes.
template <int dim>
void add_sides(const LatticeIndex<dim>& num_cells, Mesh<dim>& mesh) {
  const LatticeIndex<dim> num_lattice = num_cells + LatticeIndex<dim>::Ones();
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
    const auto cell = mesh.cell(c);
    for (int f = 0; f < num_facets(mesh.cell_type); ++f) {
      const auto local = facet_nodes(mesh.cell_type, f);
      for (int side = 0; side < 2 * dim; ++side) {
        const int axis = side / 2, plane = side % 2 == 0 ? 0 : num_cells[axis];
        bool inside = true;
        for (int a : local) inside &= lattice_index<dim>(cell[a], num_lattice)[axis] == plane;
        if (!inside) continue;
        auto& group = mesh.facet_groups[box_side_name(dim, axis, side % 2)];
        for (int a : local) group.push_back(cell[a]);
      }
    }
  }
}

}  // namespace

const char* box_side_name(int dim, int axis, int end) {
  static const char* names[2][3][2] = {{{"left", "right"}, {"bottom", "top"}, {"", ""}},
                                       {{"left", "right"}, {"front", "back"}, {"bottom", "top"}}};
  return names[dim - 2][axis][end];
}

template <int dim>
Mesh<dim> box_mesh(const Vector<dim>& low, const Vector<dim>& high,
                   const Eigen::Matrix<int, dim, 1>& num_cells, CellType cell_type,
                   bool alternate) {
  check_box<dim>(low, high, num_cells, cell_type);
  Mesh<dim> mesh;
  mesh.cell_type = cell_type;
  const LatticeIndex<dim> num_lattice = num_cells + LatticeIndex<dim>::Ones();
  mesh.nodes.resize(num_lattice.prod());
  for (std::int32_t n = 0; n < mesh.num_nodes_total(); ++n) {
    const LatticeIndex<dim> at = lattice_index<dim>(n, num_lattice);
    for (int i = 0; i < dim; ++i) {
      mesh.nodes[n][i] = lattice_coordinate(low[i], high[i], at[i], num_cells[i]);
    }
  }
  for (std::int32_t b = 0; b < num_cells.prod(); ++b) {
    const LatticeIndex<dim> at = lattice_index<dim>(b, num_cells);
    const auto brick = brick_nodes<dim>(at, num_cells);
    const bool odd = alternate && at.sum() % 2 == 1;
    if (cell_type == CellType::tri3) {
      add_pieces<3>(odd ? odd_triangles : even_triangles, brick, mesh.cells);
    } else if (cell_type == CellType::tet4) {
      add_pieces<4>(!alternate ? six_tetrahedra
                    : odd      ? odd_tetrahedra
                               : even_tetrahedra,
                    brick, mesh.cells);
    } else {
      mesh.cells.insert(mesh.cells.end(), brick.begin(), brick.end());
    }
  }
  add_sides<dim>(num_cells, mesh);
  return mesh;
}

template Mesh<2> box_mesh(const Vector<2>&, const Vector<2>&, const Eigen::Matrix<int, 2, 1>&,
                          CellType, bool);
template Mesh<3> box_mesh(const Vector<3>&, const Vector<3>&, const Eigen::Matrix<int, 3, 1>&,
                          CellType, bool);

}  // namespace gabion
