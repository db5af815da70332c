// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "common/mechanics/elements/shape_functions.hpp"
#include "common/mechanics/mesh/mesh.hpp"

namespace gabion::fem {

/// Distances between the centres of opposite facets of a quad4 or hex8, axis by axis [m].
template <int dim>
std::array<double, dim> brick_widths(const Mesh<dim>& mesh, std::int32_t c) {
  constexpr CellType type = dim == 2 ? CellType::quad4 : CellType::hex8;
  ShapeValues<dim> shape;
  shape_functions<type>(Vector<dim>::Zero(), shape);
  Matrix<dim> edges = Matrix<dim>::Zero();
  for (int a = 0; a < 1 << dim; ++a) {
    edges += 2 * mesh.nodes[mesh.cell(c)[a]] * shape.dN[a].transpose();
  }
  std::array<double, dim> widths;
  for (int axis = 0; axis < dim; ++axis) widths[axis] = edges.col(axis).norm();
  return widths;
}

}  // namespace gabion::fem
