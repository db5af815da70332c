// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/points/body_rotation.hpp"

#include <variant>

#include "common/mechanics/ranks/sum.hpp"
#include "common/mechanics/rotation_angle.hpp"

namespace gabion::mpm {

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
  return rotation_angle<dim>(C);
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
