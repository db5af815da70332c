// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/stress/averaged_batch.hpp"

#include <algorithm>
#include <cmath>

#include "common/mechanics/simd/lane_tensors.hpp"

namespace gabion::mpm {

namespace {

// (1 + x)^(1/axes) - 1 to rounding for every size of x.
template <int axes>
Lanes root_minus_one(const Lanes& x) {
  if constexpr (axes == 2) {
    return x / (1 + sqrt(1 + x));
  } else {
    const Lanes root = each([](double y) { return std::cbrt(y); }, 1 + x);
    return x / (1 + root + root * root);
  }
}

template <int n>
Lanes dot(const Lanes* a, const Lanes* b) {
  Lanes sum = a[0] * b[0];
  for (int k = 1; k < n; ++k) sum += a[k] * b[k];
  return sum;
}

}  // namespace

// x <- M x, of the first index.
template <int dim>
void AveragedBatch<dim>::keep_in_plane(Lanes* x) const {
  const Vector<dim>& normal = *normal_;
  for (int J = 0; J < dim; ++J) {
    Lanes along = normal[0] * x[J];
    for (int a = 1; a < dim; ++a) along += normal[a] * x[a * dim + J];
    for (int a = 0; a < dim; ++a) x[a * dim + J] -= normal[a] * along;
  }
}

// x <- (1 + (s - 1) M) x, of the first index.
template <int dim>
void AveragedBatch<dim>::stretch_in_plane(Lanes* x) const {
  Lanes in_plane[n];
  std::copy_n(x, n, in_plane);
  keep_in_plane(in_plane);
  for (int k = 0; k < n; ++k) x[k] += stretch_ * in_plane[k];
}

// x <- (1 + (s - 1) M) x, of both spatial indices of the tangent.
template <int dim>
void AveragedBatch<dim>::stretch_in_plane(PointBatch<dim>& batch) const {
  Lanes column[n];
  for (int bL = 0; bL < n; ++bL) {
    for (int aJ = 0; aJ < n; ++aJ) column[aJ] = batch.A[aJ * n + bL];
    stretch_in_plane(column);
    for (int aJ = 0; aJ < n; ++aJ) batch.A[aJ * n + bL] = column[aJ];
  }
  for (int aJ = 0; aJ < n; ++aJ) stretch_in_plane(&batch.A[aJ * n]);
}

template <int dim>
void AveragedBatch<dim>::start(const Lanes* H, const Lanes& V, const Vector<dim>* held_normal) {
  normal_ = held_normal;
  for (int k = 0; k < n; ++k) F_[k] = k % (dim + 1) == 0 ? 1 + H[k] : H[k];
  J_change_ = determinant_minus_one<dim>(H);
  V_ = V;
  V_change_ = V * J_change_;
}

template <int dim>
void AveragedBatch<dim>::average(const Lanes& mean_change, Lanes* H_bar) {
  const Lanes J_ratio_change = (mean_change - J_change_) / (1 + J_change_);
  if (is_slice()) {
    stretch_ = root_minus_one<2>(J_ratio_change);
    Lanes in_plane[n];
    std::copy_n(F_, n, in_plane);
    keep_in_plane(in_plane);
    for (int k = 0; k < n; ++k) H_bar[k] += stretch_ * in_plane[k];
    return;
  }
  stretch_ = root_minus_one<dim>(J_ratio_change);
  for (int k = 0; k < n; ++k) H_bar[k] += stretch_ * F_[k];
}

template <int dim>
void AveragedBatch<dim>::set_stress(const Lanes& V0, PointBatch<dim>& batch, bool with_A) {
  const Lanes s = 1 + stretch_, V0_s = is_slice() ? V0 : V0 * s;
  const double share = is_slice() ? 0.5 : 1.0 / dim;
  Lanes mean_F[n];
  for (int k = 0; k < n; ++k) mean_F[k] = F_[k] * share;
  invert_transposed<dim>(F_, J(), G_);
  for (int k = 0; k < n; ++k) Q_[k] = V0_s * batch.P[k];
  if (is_slice()) {
    keep_in_plane(mean_F);
    stretch_in_plane(Q_);
  }
  p_ = dot<n>(Q_, mean_F);
  if (!with_A) return;
  // The variation of H_bar is (1 + (s - 1) M) dH + s M F (d ln J_bar - G : dH) / d.
  const Lanes factor = is_slice() ? V0 : V0_s * s;
  Lanes y[n], z[n];
  for (int k = 0; k < n; ++k) y[k] = Q_[k] * share;
  if (is_slice()) {
    keep_in_plane(y);
    stretch_in_plane(batch);
  }
  std::copy_n(y, n, z);
  for (int aJ = 0; aJ < n; ++aJ) {
    for (int bL = 0; bL < n; ++bL) {
      Lanes& A = batch.A[aJ * n + bL];
      A *= factor;
      y[aJ] += A * mean_F[bL];
      z[bL] += A * mean_F[aJ];
    }
  }
  q_ = dot<n>(mean_F, y);
  for (int k = 0; k < n; ++k) {
    left_[k] = y[k] - q_ * G_[k];
    right_[k] = z[k] - q_ * G_[k];
  }
}

// A becomes the derivative of Q + (mean_pressure - p) G by H, at constant J_bar and mean pressure
// of the group; and what the point's share of it changes. G_aL G_bJ is -dG/dF.
template <int dim>
void AveragedBatch<dim>::add_to_tangent(const Lanes& mean_pressure, Lanes* A) const {
  const Lanes excess = p_ - mean_pressure, rest = mean_pressure - q_;
  Lanes with_G[n], excess_G[n];
  for (int k = 0; k < n; ++k) {
    with_G[k] = rest * G_[k] - right_[k];
    excess_G[k] = excess * G_[k];
  }
  for (int a = 0; a < dim; ++a) {
    for (int J = 0; J < dim; ++J) {
      for (int b = 0; b < dim; ++b) {
        for (int L = 0; L < dim; ++L) {
          const int aJ = a * dim + J, bL = b * dim + L;
          A[aJ * n + bL] +=
              G_[aJ] * with_G[bL] - left_[aJ] * G_[bL] + excess_G[a * dim + L] * G_[b * dim + J];
        }
      }
    }
  }
}

template <int dim>
void AveragedBatch<dim>::find_forces(const Lanes& mean_pressure, Lanes* P) const {
  const Lanes excess = mean_pressure - p_;
  for (int k = 0; k < n; ++k) P[k] = Q_[k] + excess * G_[k];
}

template <int dim>
void AveragedBatch<dim>::share_forces(const Lanes& mean_pressure, PointTerms<dim, 1>* to) const {
  Lanes P[n];
  find_forces(mean_pressure, P);
  spread_stress(P, to);
}

template <int dim>
void AveragedBatch<dim>::share_all(const Lanes& share, const Lanes& mean_pressure, Lanes* A,
                                   Terms* to) const {
  Lanes fields[num_fields][n];
  find_forces(mean_pressure, fields[force]);
  for (int k = 0; k < n; ++k) {
    fields[volume][k] = share * G_[k];
    fields[left][k] = left_[k];
    fields[right][k] = right_[k];
  }
  const auto ordered = [&](int k) {
    const int J = k / Terms::width, field = k % Terms::width / dim, a = k % dim;
    return fields[field][a * dim + J];
  };
  spread<dim * Terms::width>(ordered, to[0].nodal[0], sizeof *to / sizeof(double));
  add_to_tangent(mean_pressure, A);
  spread_tangent(A, to);
}

template class AveragedBatch<2>;
template class AveragedBatch<3>;

}  // namespace gabion::mpm
