// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "common/mechanics/elements/cell_type.hpp"
#include "common/mechanics/tensor.hpp"

namespace gabion {

/// Shape functions and their derivatives at one point of a reference cell of dimension `dim`.
template <int dim>
struct ShapeValues {
  double N[max_cell_nodes];
  Vector<dim> dN[max_cell_nodes];  ///< by reference coordinates xi, or by x after `map_gradients`
};

/// N_a(xi) and dN_a/dxi. @pre dimension(type) == dim
template <int dim>
void shape_functions(CellType type, const Vector<dim>& xi, ShapeValues<dim>& out);

/// Turn dN/dxi into dN/dx for a cell with these node positions.
/// @returns det(dx/dxi)
template <int dim>
double map_gradients(CellType type, const Vector<dim>* x_nodes, ShapeValues<dim>& shape);

/// Quadrature of a reference cell.
template <int dim>
struct QuadraturePoint {
  Vector<dim> xi;
  double weight;  ///< sums to the volume of the reference cell
};

/// Gauss rule exact for polynomials of this degree (1 to 3 at least; products for quad and hex).
template <int dim>
std::vector<QuadraturePoint<dim>> gauss_rule(CellType type, int degree);

/// Rule with this many points of positive weight inside the cell, for laying material points:
/// tri3 1, 3, 4, 6, 12, 16; quad4 1, 4, 9, 16; tet4 1, 4; hex8 1, 8, 27.
/// @throws ConfigError  names the counts allowed for this cell
template <int dim>
std::vector<QuadraturePoint<dim>> point_rule(CellType type, int num_points);

}  // namespace gabion
