// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "common/base/require.hpp"
#include "common/mechanics/elements/cell_facets.hpp"
#include "common/mechanics/mesh/box_lattice.hpp"
#include "common/mechanics/mesh/mesh.hpp"
#include "common/mechanics/mesh/mesh_part.hpp"

namespace gabion {

namespace {

template <int n>
using Pieces = std::vector<std::array<int, n>>;

// Cut of a quad or hex (local nodes in Gmsh's order). Even and odd pieces meet each other's
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
LatticeIndex<dim> num_lattice(const BoxShape<dim>& box) {
  return box.num_cells + LatticeIndex<dim>::Ones();
}

template <int dim>
Vector<dim> node_position(const BoxShape<dim>& box, std::int32_t node) {
  const LatticeIndex<dim> at = lattice_index<dim>(node, num_lattice(box));
  Vector<dim> x;
  for (int i = 0; i < dim; ++i) {
    x[i] = lattice_coordinate(box.low[i], box.high[i], at[i], box.num_cells[i]);
  }
  return x;
}

/// The cells of one rectangle or brick. @returns their number
template <int dim>
int add_brick(const BoxShape<dim>& box, std::int32_t b, std::vector<std::int32_t>& cells) {
  const LatticeIndex<dim> at = lattice_index<dim>(b, box.num_cells);
  const auto brick = brick_nodes<dim>(at, box.num_cells);
  const bool odd = box.alternate && at.sum() % 2 == 1;
  const std::size_t before = cells.size();
  if (box.cell_type == CellType::tri3) {
    add_pieces<3>(odd ? odd_triangles : even_triangles, brick, cells);
  } else if (box.cell_type == CellType::tet4) {
    add_pieces<4>(!box.alternate ? six_tetrahedra
                  : odd          ? odd_tetrahedra
                                 : even_tetrahedra,
                  brick, cells);
  } else {
    cells.insert(cells.end(), brick.begin(), brick.end());
  }
  return static_cast<int>(cells.size() - before) / num_nodes(box.cell_type);
}

/// Facets of cells that lie in a side of the box, told by the lattice positions of their nodes.
/// @param mesh  its nodes still have the numbers of the lattice
/// @param add   called with the name of the side, the cell and its facet
template <int dim, class Add>
void for_each_side_facet(const BoxShape<dim>& box, const Mesh<dim>& mesh, const Add& add) {
  const LatticeIndex<dim> lengths = num_lattice(box);
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
    const auto cell = mesh.cell(c);
    for (int f = 0; f < num_facets(mesh.cell_type); ++f) {
      const auto local = facet_nodes(mesh.cell_type, f);
      for (int side = 0; side < 2 * dim; ++side) {
        const int axis = side / 2, plane = side % 2 == 0 ? 0 : box.num_cells[axis];
        bool inside = true;
        for (int a : local) inside &= lattice_index<dim>(cell[a], lengths)[axis] == plane;
        if (inside) add(box_side_name(dim, axis, side % 2), c, f);
      }
    }
  }
}

template <int dim>
void add_facet(Mesh<dim>& mesh, const char* side, std::int32_t c, int f) {
  auto& group = mesh.facet_groups[side];
  for (int a : facet_nodes(mesh.cell_type, f)) group.push_back(mesh.cell(c)[a]);
}

/// Number the nodes of a part anew. @returns their numbers so far, ascending
template <int dim>
std::vector<std::int32_t> number_anew(Mesh<dim>& mesh) {
  std::vector<std::int32_t> nodes = mesh.cells;
  std::ranges::sort(nodes);
  nodes.erase(std::ranges::unique(nodes).begin(), nodes.end());
  const auto place = [&](std::int32_t i) {
    return static_cast<std::int32_t>(std::ranges::lower_bound(nodes, i) - nodes.begin());
  };
  std::ranges::transform(mesh.cells, mesh.cells.begin(), place);
  for (auto& [name, facets] : mesh.facet_groups) {
    std::ranges::transform(facets, facets.begin(), place);
  }
  return nodes;
}

template <int dim>
Vector<dim> brick_centre(const BoxShape<dim>& box, std::int32_t b) {
  const LatticeIndex<dim> at = lattice_index<dim>(b, box.num_cells);
  Vector<dim> x;
  for (int i = 0; i < dim; ++i) {
    x[i] = 0.5 * (lattice_coordinate(box.low[i], box.high[i], at[i], box.num_cells[i]) +
                  lattice_coordinate(box.low[i], box.high[i], at[i] + 1, box.num_cells[i]));
  }
  return x;
}

}  // namespace

const char* box_side_name(int dim, int axis, int end) {
  static const char* names[2][3][2] = {{{"left", "right"}, {"bottom", "top"}, {"", ""}},
                                       {{"left", "right"}, {"front", "back"}, {"bottom", "top"}}};
  return names[dim - 2][axis][end];
}

template <int dim>
void check_box(const BoxShape<dim>& box) {
  require<ConfigError>(
      dimension(box.cell_type) == dim, "box mesh of dimension {}: found cell type {}, allowed: {}",
      dim, name(box.cell_type),
      dim == 2 ? "tri3, quad4, tri6, quad8, quad9" : "tet4, hex8, tet10, hex20, hex27");
  std::int64_t num_nodes_total = 1;
  for (int i = 0; i < dim; ++i) {
    require<ConfigError>(box.low[i] < box.high[i],
                         "box mesh, axis {}: found low {} and high {}, allowed: low < high", i,
                         box.low[i], box.high[i]);
    require<ConfigError>(box.num_cells[i] >= 1,
                         "box mesh, axis {}: found {} cells, allowed: at least 1", i,
                         box.num_cells[i]);
    num_nodes_total *= std::int64_t{box.num_cells[i]} + 1;
    require<ConfigError>(num_nodes_total < (std::int64_t{1} << 31) / 48,
                         "box mesh: found more cells than 32-bit indices can count");
  }
}

template <int dim>
Mesh<dim> box_mesh(const Vector<dim>& low, const Vector<dim>& high,
                   const Eigen::Matrix<int, dim, 1>& num_cells, CellType cell_type,
                   bool alternate) {
  if (is_quadratic(cell_type)) {
    check_box(BoxShape<dim>{low, high, num_cells, cell_type, alternate});
    return with_middle_nodes(box_mesh(low, high, num_cells, corner_type(cell_type), alternate),
                             cell_type);
  }
  const BoxShape<dim> box{low, high, num_cells, cell_type, alternate};
  check_box(box);
  Mesh<dim> mesh;
  mesh.cell_type = cell_type;
  mesh.nodes.resize(num_lattice(box).prod());
  for (std::int32_t n = 0; n < mesh.num_nodes_total(); ++n) mesh.nodes[n] = node_position(box, n);
  for (std::int32_t b = 0; b < num_cells.prod(); ++b) add_brick(box, b, mesh.cells);
  for_each_side_facet(
      box, mesh, [&](const char* side, std::int32_t c, int f) { add_facet(mesh, side, c, f); });
  return mesh;
}

template <int dim>
std::vector<Vector<dim>> brick_centres(const BoxShape<dim>& box, std::int32_t first,
                                       std::int32_t last) {
  std::vector<Vector<dim>> centres;
  for (std::int32_t b = first; b < last; ++b) centres.push_back(brick_centre(box, b));
  return centres;
}

template <int dim>
MeshPart<dim> box_part(const BoxShape<dim>& box,
                       const std::function<bool(const Vector<dim>&)>& wanted) {
  check_box(box);
  MeshPart<dim> part;
  Mesh<dim>& mesh = part.mesh;
  PartNumbers& numbers = part.numbers;
  mesh.cell_type = box.cell_type;
  std::vector<std::int32_t> brick;
  for (std::int32_t b = 0; b < box.num_cells.prod(); ++b) {
    brick.clear();
    const int count = add_brick(box, b, brick);
    if (wanted(brick_centre(box, b))) {
      mesh.cells.insert(mesh.cells.end(), brick.begin(), brick.end());
      for (int k = 0; k < count; ++k) numbers.cells.push_back(numbers.num_cells + k);
    }
    numbers.num_cells += count;
  }
  numbers.num_nodes = num_lattice(box).prod();
  for (int side = 0; side < 2 * dim; ++side) {
    mesh.facet_groups[box_side_name(dim, side / 2, side % 2)];
    numbers.facets[box_side_name(dim, side / 2, side % 2)];
  }
  const int facets_per_cell = num_facets(box.cell_type);
  for_each_side_facet(box, mesh, [&](const char* side, std::int32_t c, int f) {
    add_facet(mesh, side, c, f);
    numbers.facets[side].push_back(std::int64_t{numbers.cells[c]} * facets_per_cell + f);
  });
  numbers.nodes = number_anew(mesh);
  for (const std::int32_t i : numbers.nodes) mesh.nodes.push_back(node_position(box, i));
  return part;
}

template void check_box(const BoxShape<2>&);
template void check_box(const BoxShape<3>&);
template Mesh<2> box_mesh(const Vector<2>&, const Vector<2>&, const Eigen::Matrix<int, 2, 1>&,
                          CellType, bool);
template Mesh<3> box_mesh(const Vector<3>&, const Vector<3>&, const Eigen::Matrix<int, 3, 1>&,
                          CellType, bool);
template std::vector<Vector<2>> brick_centres(const BoxShape<2>&, std::int32_t, std::int32_t);
template std::vector<Vector<3>> brick_centres(const BoxShape<3>&, std::int32_t, std::int32_t);
template MeshPart<2> box_part(const BoxShape<2>&, const std::function<bool(const Vector<2>&)>&);
template MeshPart<3> box_part(const BoxShape<3>&, const std::function<bool(const Vector<3>&)>&);

}  // namespace gabion
