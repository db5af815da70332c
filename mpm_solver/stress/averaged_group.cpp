// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/stress/averaged_group.hpp"

#include <cmath>

#include "common/mechanics/tensor_functions.hpp"

namespace gabion::mpm {

template <int dim>
typename AveragedGroup<dim>::Flat AveragedGroup<dim>::flat(const Matrix<dim>& m) {
  Flat f;
  for (int aJ = 0; aJ < dim * dim; ++aJ) f[aJ] = m(aJ / dim, aJ % dim);
  return f;
}

template <int dim>
Matrix<dim> AveragedGroup<dim>::unflat(const Flat& f) {
  Matrix<dim> m;
  for (int aJ = 0; aJ < dim * dim; ++aJ) m(aJ / dim, aJ % dim) = f[aJ];
  return m;
}

// T_(aJ)(bL) = G_aL G_bJ, which is -dG/dF.
template <int dim>
Tangent<dim> AveragedGroup<dim>::inverse_product(const Matrix<dim>& G) {
  Tangent<dim> T;
  for (int aJ = 0; aJ < dim * dim; ++aJ) {
    for (int bL = 0; bL < dim * dim; ++bL) {
      T(aJ, bL) = G(aJ / dim, bL % dim) * G(bL / dim, aJ % dim);
    }
  }
  return T;
}

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
  point.stretch = std::expm1((std::log1p(mean_change) - std::log1p(point.change)) / dim);
  return point.H + point.stretch * (Matrix<dim>::Identity() + point.H);
}

template <int dim>
void AveragedGroup<dim>::set_stress(std::size_t k, double V0, const Matrix<dim>& P_bar,
                                    const Tangent<dim>* A) {
  Point& point = points_[k];
  const double s = 1 + point.stretch;
  const Matrix<dim> F = Matrix<dim>::Identity() + point.H;
  point.G = F.inverse().transpose();
  point.Q = V0 * s * P_bar;
  point.p = point.Q.cwiseProduct(F).sum() / dim;
  pressure += point.p;
  if (!A) return;
  // The variation of H_bar is s dH + F_bar (d ln J_bar - G : dH) / dim.
  const Flat F_bar = flat(s * F), G = flat(point.G), Q = flat(point.Q);
  const Flat by_stretch = *A * F_bar;
  const Flat of_stretch = A->transpose() * F_bar;
  const Flat y = (V0 * s * by_stretch + Q) / dim;
  const Flat z = (V0 * s * of_stretch + Q) / dim;
  const double q = V0 * F_bar.dot(by_stretch) / (dim * dim) + point.p / dim;
  point.M = V0 * s * s * *A - G * z.transpose() + (q * G - y) * G.transpose() +
            point.p * inverse_product(point.G);
  point.left = unflat(y - q * G);
  point.right = unflat(z - q * G);
  coupling_ += q;
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
                                    const double* gradient, CellForces<dim>& sum) {
  double left[CellForces<dim>::max_dofs], right[CellForces<dim>::max_dofs];
  const int num_dofs = group.num_nodes * dim;
  double own_pressure = 0;
  if (gradient) {
    for (const Point& point : points_) own_pressure += point.p;
    for (int i = 0; i < num_dofs; ++i) {
      left[i] = 0;
      right[i] = (coupling_ - own_pressure) * gradient[i];
    }
  }
  for (std::size_t k = 0; k < points_.size(); ++k) {
    const auto e = group.first + static_cast<std::int32_t>(k);
    const int n = weights.num_nodes(e);
    const std::uint8_t* local = weights.local_of(e);
    const Vector<dim>* grad = weights.grad_of(e);
    Point& point = points_[k];
    const double mean_pressure = pressure * share(point);
    sum.add_stress(n, local, point.Q + (mean_pressure - point.p) * point.G, grad);
    if (!gradient) continue;
    const Flat G = flat(point.G);
    point.M += mean_pressure * (G * G.transpose() - inverse_product(point.G));
    sum.add_tangent(n, local, group.num_nodes, point.M, grad);
    add_gradients<dim>(n, local, point.left, grad, left);
    add_gradients<dim>(n, local, point.right, grad, right);
  }
  if (!gradient) return;
  sum.add_product(num_dofs, left, gradient);
  sum.add_product(num_dofs, gradient, right);
}

template class AveragedGroup<2>;
template class AveragedGroup<3>;

}  // namespace gabion::mpm
