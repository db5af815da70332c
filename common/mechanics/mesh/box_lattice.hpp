// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "common/mechanics/tensor.hpp"

namespace gabion {

// Numbers and places in a box of equal rectangles or bricks: along x first, then y, then z.

template <int dim>
using LatticeIndex = Eigen::Matrix<int, dim, 1>;

/// Steps from the first corner of a quad or hex to the others, in Gmsh's order.
inline constexpr int brick_corners[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                            {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};

/// Place of a number in rows of these lengths.
template <int dim>
LatticeIndex<dim> lattice_index(std::int32_t number, const LatticeIndex<dim>& lengths) {
  LatticeIndex<dim> at;
  for (int d = 0; d + 1 < dim; ++d) {
    at[d] = number % lengths[d];
    number /= lengths[d];
  }
  at[dim - 1] = number;
  return at;
}

/// Node at a place. @param num_cells  along each axis
template <int dim>
std::int32_t lattice_node(const LatticeIndex<dim>& at, const LatticeIndex<dim>& num_cells) {
  std::int32_t node = at[dim - 1];
  for (int d = dim - 2; d >= 0; --d) node = node * (num_cells[d] + 1) + at[d];
  return node;
}

/// Nodes of the rectangle or brick at a place, in Gmsh's order.
template <int dim>
std::array<std::int32_t, (1 << dim)> brick_nodes(const LatticeIndex<dim>& cell,
                                                 const LatticeIndex<dim>& num_cells) {
  std::array<std::int32_t, (1 << dim)> nodes;
  const std::int32_t first = lattice_node<dim>(cell, num_cells);
  for (int a = 0; a < (1 << dim); ++a) {
    nodes[a] = first;
    for (int d = 0, stride = 1; d < dim; stride *= num_cells[d++] + 1) {
      nodes[a] += brick_corners[a][d] * stride;
    }
  }
  return nodes;
}

/// Coordinate of the nodes at place `at` of `num_cells` cells along an axis [m].
inline double lattice_coordinate(double low, double high, int at, int num_cells) {
  return at == num_cells ? high : low + (high - low) * at / num_cells;
}

}  // namespace gabion
