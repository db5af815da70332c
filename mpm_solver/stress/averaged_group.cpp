// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/stress/averaged_group.hpp"

#include <cmath>

#include "common/mechanics/tensor_functions.hpp"

namespace gabion::mpm {

namespace {

// (1 + x)^(1/dim) - 1 to rounding for every size of x.
template <int dim>
double root_minus_one(double x) {
  if constexpr (dim == 2) {
    return x / (1 + std::sqrt(1 + x));
  } else {
    const double root = std::cbrt(1 + x);
    return x / (1 + root + root * root);
  }
}

}  // namespace

template <int dim>
double AveragedGroup<dim>::add_point(const Matrix<dim>& H, double V) {
  Point& point = points_.emplace_back();
  point.H = H;
  point.V = V;
  point.change = determinant_minus_one<dim>(H);
  volumes.before += V;
  volumes.change += V * point.change;
  return 1 + point.change;
}

template <int dim>
Matrix<dim> AveragedGroup<dim>::averaged_gradient(std::size_t k) {
  Point& point = points_[k];
  const double mean_change = volumes.change / volumes.before;
  point.stretch = root_minus_one<dim>((mean_change - point.change) / (1 + point.change));
  return point.H + point.stretch * (Matrix<dim>::Identity() + point.H);
}

template <int dim>
void AveragedGroup<dim>::set_stress(std::size_t k, double V0, const Matrix<dim>& P_bar,
                                    const Tangent<dim>* A) {
  Point& point = points_[k];
  const double s = 1 + point.stretch;
  const Matrix<dim> F = Matrix<dim>::Identity() + point.H;
  const Flat<dim> mean_F = row_by_row<dim>(F) / dim;
  point.G = row_by_row<dim>(F.inverse().transpose());
  point.Q = V0 * s * row_by_row<dim>(P_bar);
  point.p = point.Q.dot(mean_F);
  pressure += point.p;
  if (!A) return;
  // The variation of H_bar is s dH + F_bar (d ln J_bar - G : dH) / dim.
  point.A = V0 * s * s * *A;
  const Flat<dim> y = point.A * mean_F + point.Q / dim;
  const Flat<dim> z = point.A.transpose() * mean_F + point.Q / dim;
  point.q = mean_F.dot(y);
  point.left = y - point.q * point.G;
  point.right = z - point.q * point.G;
  coupling_ += point.q;
}

template <int dim>
void AveragedGroup<dim>::add_volume_gradient(const PointWeights<dim>& weights,
                                             const CellGroup& group, double* gradient) const {
  for (std::size_t k = 0; k < points_.size(); ++k) {
    const auto e = group.first + static_cast<std::int32_t>(k);
    add_gradients<dim>(weights.num_nodes(e), weights.local_of(e), share(points_[k]) * points_[k].G,
                       weights.grad_of(e), gradient);
  }
}

template <int dim>
void AveragedGroup<dim>::add_forces(const PointWeights<dim>& weights, const CellGroup& group,
                                    const double* gradient, CellForces<dim>& sum) const {
  for (std::size_t k = 0; k < points_.size(); ++k) {
    const auto e = group.first + static_cast<std::int32_t>(k);
    const Point& point = points_[k];
    const Flat<dim> stress = point.Q + (pressure * share(point) - point.p) * point.G;
    add_gradients<dim>(weights.num_nodes(e), weights.local_of(e), stress, weights.grad_of(e),
                       sum.f);
  }
  if (gradient) add_stiffness(weights, group, gradient, sum);
}

// Of Q + (mean_pressure - p) G by H, at constant J_bar and mean pressure of the group; and what the
// point's share of it changes. G_aL G_bJ is -dG/dF.
template <int dim>
Tangent<dim> AveragedGroup<dim>::tangent(const Point& point, double mean_pressure) {
  const Flat<dim>& G = point.G;
  const Flat<dim> with_G = (mean_pressure - point.q) * G - point.right;
  const double excess = point.p - mean_pressure;
  Tangent<dim> M = point.A;
  for (int aJ = 0; aJ < dim * dim; ++aJ) {
    for (int bL = 0; bL < dim * dim; ++bL) {
      const double crossed = G[aJ / dim * dim + bL % dim] * G[bL / dim * dim + aJ % dim];
      M(aJ, bL) += G[aJ] * with_G[bL] - point.left[aJ] * G[bL] + excess * crossed;
    }
  }
  return M;
}

template <int dim>
void AveragedGroup<dim>::add_stiffness(const PointWeights<dim>& weights, const CellGroup& group,
                                       const double* gradient, CellForces<dim>& sum) const {
  double left[CellForces<dim>::max_dofs], right[CellForces<dim>::max_dofs];
  double own_pressure = 0;
  for (const Point& point : points_) own_pressure += point.p;
  for (int i = 0; i < group.num_nodes * dim; ++i) {
    left[i] = 0;
    right[i] = (coupling_ - own_pressure) * gradient[i];
  }
  for (std::size_t k = 0; k < points_.size(); ++k) {
    const auto e = group.first + static_cast<std::int32_t>(k);
    const int n = weights.num_nodes(e);
    add_gradients<dim>(n, weights.local_of(e), points_[k].left, weights.grad_of(e), left);
    add_gradients<dim>(n, weights.local_of(e), points_[k].right, weights.grad_of(e), right);
  }
  sum.set_products(group.num_nodes, left, gradient, right);
  for (std::size_t k = 0; k < points_.size(); ++k) {
    const auto e = group.first + static_cast<std::int32_t>(k);
    sum.add_tangent(weights.num_nodes(e), weights.local_of(e), group.num_nodes,
                    tangent(points_[k], pressure * share(points_[k])), weights.grad_of(e));
  }
}

template class AveragedGroup<2>;
template class AveragedGroup<3>;

}  // namespace gabion::mpm
