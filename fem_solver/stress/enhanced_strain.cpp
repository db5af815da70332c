// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/stress/enhanced_strain.hpp"

#include <Eigen/LU>

namespace gabion::fem {

namespace {

template <int dim>
constexpr CellType brick = dim == 2 ? CellType::quad4 : CellType::hex8;

/// Row alpha is dx / dxi_alpha.
template <int dim>
Matrix<dim> jacobian_at(const Vector<dim>& xi, std::span<const Vector<dim>> x_nodes) {
  ShapeValues<dim> shape;
  shape_functions<brick<dim>>(xi, shape);
  Matrix<dim> J = Matrix<dim>::Zero();
  for (std::size_t a = 0; a < x_nodes.size(); ++a) J += shape.dN[a] * x_nodes[a].transpose();
  return J;
}

/// A mode on the axes of the reference cell: xi_k times a tensor.
template <int dim>
struct Mode {
  int k = 0;
  Matrix<dim> tensor = Matrix<dim>::Zero();
};

/// xi_i e_i e_i; of each pair i < j, xi_i and xi_j times sym(e_i e_j).
template <int dim>
std::array<Mode<dim>, num_modes<dim>> reference_modes() {
  std::array<Mode<dim>, num_modes<dim>> modes;
  int next = 0;
  const auto add = [&](int k, int i, int j) {
    modes[next].k = k;
    modes[next].tensor(i, j) = modes[next].tensor(j, i) = i == j ? 1 : 0.5;
    ++next;
  };
  for (int i = 0; i < dim; ++i) add(i, i, i);
  for (int i = 0; i < dim; ++i) {
    for (int j = i + 1; j < dim; ++j) {
      add(i, i, j);
      add(j, i, j);
    }
  }
  return modes;
}

}  // namespace

template <int dim>
std::vector<ModeStrains<dim>> enhancing_modes(std::span<const Vector<dim>> x_nodes,
                                              std::span<const QuadraturePoint<dim>> rule) {
  const Matrix<dim> J_0 = jacobian_at<dim>(Vector<dim>::Zero(), x_nodes);
  const Matrix<dim> J_0_inverse = J_0.inverse();
  auto modes = reference_modes<dim>();
  for (Mode<dim>& mode : modes) {  // strains of unit size, whatever the size of the cell
    mode.tensor = (J_0_inverse * mode.tensor * J_0_inverse.transpose()).eval();
    mode.tensor.normalize();
  }
  std::vector<ModeStrains<dim>> at_points;
  for (const auto& point : rule) {
    const double scale = J_0.determinant() / jacobian_at<dim>(point.xi, x_nodes).determinant();
    ModeStrains<dim> M;
    for (int m = 0; m < num_modes<dim>; ++m) {
      M.col(m) = scale * point.xi[modes[m].k] * strain_vector<dim>(modes[m].tensor);
    }
    at_points.push_back(M);
  }
  return at_points;
}

template std::vector<ModeStrains<2>> enhancing_modes<2>(std::span<const Vector<2>>,
                                                        std::span<const QuadraturePoint<2>>);
template std::vector<ModeStrains<3>> enhancing_modes<3>(std::span<const Vector<3>>,
                                                        std::span<const QuadraturePoint<3>>);

}  // namespace gabion::fem
