// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/elements/shape_functions.hpp"

#include <Eigen/LU>
#include <cassert>

namespace gabion {

template <int dim>
void shape_functions(CellType type, const Vector<dim>& xi, ShapeValues<dim>& out) {
  assert(dimension(type) == dim);
  if constexpr (dim == 1) {
    shape_functions<CellType::line2>(xi, out);
  } else if constexpr (dim == 2) {
    if (type == CellType::tri3) {
      shape_functions<CellType::tri3>(xi, out);
    } else {
      shape_functions<CellType::quad4>(xi, out);
    }
  } else {
    if (type == CellType::tet4) {
      shape_functions<CellType::tet4>(xi, out);
    } else {
      shape_functions<CellType::hex8>(xi, out);
    }
  }
}

namespace {

template <int dim, class Shape>
double map_to_cell(CellType type, const Vector<dim>* x_nodes, Shape& shape) {
  assert(dimension(type) == dim);
  Matrix<dim> jacobian = Matrix<dim>::Zero();  // dx_i / dxi_j
  const int n = num_nodes(type);
  for (int a = 0; a < n; ++a) jacobian += x_nodes[a] * shape.dN[a].transpose();
  const double determinant = jacobian.determinant();
  const Matrix<dim> inverse_transpose = jacobian.inverse().transpose();
  for (int a = 0; a < n; ++a) shape.dN[a] = (inverse_transpose * shape.dN[a]).eval();
  return determinant;
}

}  // namespace

template <int dim>
double map_gradients(CellType type, const Vector<dim>* x_nodes, ShapeValues<dim>& shape) {
  return map_to_cell<dim>(type, x_nodes, shape);
}

template <int dim>
double map_gradients(CellType type, const Vector<dim>* x_nodes, AnyShapeValues<dim>& shape) {
  return map_to_cell<dim>(type, x_nodes, shape);
}

template void shape_functions(CellType, const Vector<1>&, ShapeValues<1>&);
template void shape_functions(CellType, const Vector<2>&, ShapeValues<2>&);
template void shape_functions(CellType, const Vector<3>&, ShapeValues<3>&);
template double map_gradients(CellType, const Vector<2>*, ShapeValues<2>&);
template double map_gradients(CellType, const Vector<3>*, ShapeValues<3>&);
template double map_gradients(CellType, const Vector<2>*, AnyShapeValues<2>&);
template double map_gradients(CellType, const Vector<3>*, AnyShapeValues<3>&);

}  // namespace gabion
