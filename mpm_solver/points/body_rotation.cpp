// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/points/body_rotation.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <variant>

#include "common/mechanics/ranks/sum.hpp"

namespace gabion::mpm {

namespace {

/// Of the rotation R with the largest R : C (Kabsch 1976).
template <int dim>
double angle_of_fit(const Matrix<dim>& C) {
  if constexpr (dim == 2) {
    return std::abs(std::atan2(C(1, 0) - C(0, 1), C(0, 0) + C(1, 1)));
  } else {
    const Eigen::JacobiSVD<Matrix<dim>> svd(C, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Matrix<dim> U = svd.matrixU();
    if ((U * svd.matrixV().transpose()).determinant() < 0) U.col(dim - 1) *= -1;
    const Matrix<dim> R = U * svd.matrixV().transpose();
    return std::acos(std::clamp(0.5 * (R.trace() - 1), -1.0, 1.0));
  }
}

}  // namespace

template <int dim>
double body_rotation(MPI_Comm comm, const MaterialPoints<dim>& points, std::size_t body) {
  const auto first = points.body_starts[body], last = points.body_starts[body + 1];
  double sums[1 + 2 * dim] = {};
  Eigen::Map<Vector<dim>> now(sums + 1), start(sums + 1 + dim);
  for (auto p = first; p < last; ++p) {
    sums[0] += points.m[p];
    now += points.m[p] * points.x[p];
    start += points.m[p] * (points.x[p] - points.u[p]);
  }
  sum_over_ranks(comm, std::span<double>(sums));
  if (!(sums[0] > 0)) return 0;
  now /= sums[0];
  start /= sums[0];
  Matrix<dim> C = Matrix<dim>::Zero();
  for (auto p = first; p < last; ++p) {
    const Vector<dim> x = points.x[p] - now, X = points.x[p] - points.u[p] - start;
    C += points.m[p] * x * X.transpose();
  }
  sum_over_ranks(comm, std::span<double>(C.data(), dim * dim));
  return angle_of_fit<dim>(C);
}

template <int dim>
void BodyRotations<dim>::look(const MaterialPoints<dim>& points) {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (!std::holds_alternative<LinearElastic<dim>>(bodies_[b].material.law)) continue;
    warnings_[b].look(body_rotation<dim>(comm_, points, b), "body \"" + bodies_[b].name + "\"");
  }
}

template double body_rotation<2>(MPI_Comm, const MaterialPoints<2>&, std::size_t);
template double body_rotation<3>(MPI_Comm, const MaterialPoints<3>&, std::size_t);
template class BodyRotations<2>;
template class BodyRotations<3>;

}  // namespace gabion::mpm
