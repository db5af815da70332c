// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/grid/point_domains.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

namespace gabion::mpm {

template <int dim>
Vector<dim> axis_stretches(const Matrix<dim>& F) {
  const Matrix<dim> C = F.transpose() * F;
  if constexpr (dim == 2) {
    // Square root by Cayley and Hamilton: U^2 - tr(U) U + det(U) 1 = 0.
    const double det_U = std::abs(F.determinant());
    const double tr_U = std::sqrt(C.trace() + 2 * det_U);
    return (C.diagonal().array() + det_U) / tr_U;
  } else {
    const Eigen::SelfAdjointEigenSolver<Matrix<3>> spectrum(C);
    return spectrum.eigenvectors().cwiseAbs2() * spectrum.eigenvalues().cwiseSqrt();
  }
}

template <int dim>
void deform_points(const GridNodes<dim>& nodes, std::span<const double> du,
                   const PointWeights<dim>& weights, MaterialPoints<dim>& points) {
  if (points.half_length.empty()) return;
  std::int32_t active[max_group_nodes<dim>];
  for (const CellGroup& group : weights.groups) {
    nodes.list_active(weights.nodes_of(group), active);
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const int n = weights.num_nodes(e);
      const std::uint8_t* local = weights.local_of(e);
      const Vector<dim>* grad = weights.grad_of(weights.constant_gradient ? group.first : e);
      Matrix<dim> F = Matrix<dim>::Identity();
      for (int i = 0; i < n; ++i) {
        const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(active[local[i]]) * dim;
        F += Eigen::Map<const Vector<dim>>(du.data() + row) * grad[i].transpose();
      }
      const Vector<dim> stretches = axis_stretches<dim>(F);
      const double scale = cube_side<dim>(F.determinant() / stretches.prod());
      points.half_length[weights.point[e]].array() *= scale * stretches.array();
    }
  }
}

template Vector<2> axis_stretches<2>(const Matrix<2>&);
template Vector<3> axis_stretches<3>(const Matrix<3>&);
template void deform_points<2>(const GridNodes<2>&, std::span<const double>, const PointWeights<2>&,
                               MaterialPoints<2>&);
template void deform_points<3>(const GridNodes<3>&, std::span<const double>, const PointWeights<3>&,
                               MaterialPoints<3>&);

}  // namespace gabion::mpm
