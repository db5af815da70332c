// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "common/mechanics/elements/cell_type.hpp"
#include "common/mechanics/tensor.hpp"

namespace gabion {

/// Shape functions and their derivatives at one point of a reference cell of dimension `dim`.
template <int dim, int max_nodes = max_cell_nodes>
struct ShapeValues {
  double N[max_nodes];
  Vector<dim> dN[max_nodes];  ///< by reference coordinates xi, or by x after `map_gradients`
};

/// Shape functions with room for quadratic cells.
template <int dim>
using AnyShapeValues = ShapeValues<dim, max_quadratic_nodes>;

/// N_a(xi) and dN_a/dxi of a cell type known to the compiler; for hot loops.
template <CellType type>
inline void shape_functions(const Vector<dimension(type)>& xi, ShapeValues<dimension(type)>& out) {
  constexpr int dim = dimension(type);
  if constexpr (type == CellType::tri3 || type == CellType::tet4) {
    out.N[0] = 1.0 - xi.sum();
    out.dN[0].setConstant(-1.0);
    for (int i = 0; i < dim; ++i) {
      out.N[i + 1] = xi[i];
      out.dN[i + 1] = Vector<dim>::Unit(i);
    }
  } else {
    // Corner signs in Gmsh's order: counter-clockwise, bottom face before top face.
    constexpr int sign[8][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                                {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};
    for (int a = 0; a < num_nodes(type); ++a) {
      double factor[dim];
      for (int i = 0; i < dim; ++i) factor[i] = 0.5 * (1.0 + sign[a][i] * xi[i]);
      out.N[a] = 1.0;
      for (int i = 0; i < dim; ++i) {
        out.N[a] *= factor[i];
        double slope = 0.5 * sign[a][i];
        for (int j = 0; j < dim; ++j) {
          if (j != i) slope *= factor[j];
        }
        out.dN[a][i] = slope;
      }
    }
  }
}

/// N_a(xi) and dN_a/dxi of a linear cell; dim 1 (line2), 2 and 3. @pre dimension(type) == dim
template <int dim>
void shape_functions(CellType type, const Vector<dim>& xi, ShapeValues<dim>& out);
/// N_a(xi) and dN_a/dxi of any cell (quadratic_cells.cpp).
template <int dim>
void shape_functions(CellType type, const Vector<dim>& xi, AnyShapeValues<dim>& out);

/// Turn dN/dxi into dN/dx for a cell with these node positions; dim 2 and 3.
/// The caller checks the result: gradients of a cell with determinant <= 0 mean nothing.
/// @returns det(dx/dxi)
template <int dim>
double map_gradients(CellType type, const Vector<dim>* x_nodes, ShapeValues<dim>& shape);
template <int dim>
double map_gradients(CellType type, const Vector<dim>* x_nodes, AnyShapeValues<dim>& shape);

/// Quadrature of a reference cell.
template <int dim>
struct QuadraturePoint {
  Vector<dim> xi;
  double weight;  ///< sums to the volume of the reference cell
};

/// Gauss rule exact for polynomials of this degree, weights positive, points inside; dim 1 (line2),
/// 2 and 3. Lines, quads and hexes: products, exact for this degree in each coordinate, 0 to 7;
/// triangles 0 to 6, tetrahedra 0 to 5 (total degree).
/// @throws Error  degree above these
template <int dim>
std::vector<QuadraturePoint<dim>> gauss_rule(CellType type, int degree);

/// Layout of the points of a quad or hex: the points of the Gauss rule, or the centres of equal
/// parts, which then fill the cell without overlap. Triangles and tetrahedra have one such
/// division.
enum class PointPlacement { gauss, regular };

/// Rule with this many points of positive weight inside the cell, for laying material points:
/// tri3 1, 3, 4, 6, 12, 16; quad4 1, 4, 9, 16; tet4 1, 4; hex8 1, 8, 27.
/// @throws ConfigError  names the counts allowed for this cell
template <int dim>
std::vector<QuadraturePoint<dim>> point_rule(CellType type, int num_points,
                                             PointPlacement placement = PointPlacement::gauss);

}  // namespace gabion
