// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/materials/spectral.hpp"

namespace gabion {
namespace {

/// Rotate the plane (p, q) of the symmetric A so that A(p, q) vanishes; n <- n R.
/// @see Golub and Van Loan, Matrix Computations (2013), section 8.5.2
void rotate(Eigen::Matrix3d& A, Eigen::Matrix3d& n, int p, int q) {
  const double ratio = (A(q, q) - A(p, p)) / (2 * A(p, q));
  const double t = std::copysign(1.0, ratio) / (std::abs(ratio) + std::sqrt(1 + ratio * ratio));
  const double c = 1 / std::sqrt(1 + t * t), s = t * c;
  const int r = 3 - p - q;
  const double shift = t * A(p, q), rp = A(r, p), rq = A(r, q);
  A(p, p) -= shift;
  A(q, q) += shift;
  A(p, q) = A(q, p) = 0;
  A(r, p) = A(p, r) = c * rp - s * rq;
  A(r, q) = A(q, r) = s * rp + c * rq;
  const Eigen::Vector3d n_p = n.col(p);
  n.col(p) = c * n_p - s * n.col(q);
  n.col(q) = s * n_p + c * n.col(q);
}

}  // namespace

template <>
Eigenpairs<3> eigenpairs<3>(const Symmetric<3>& s) {
  Eigen::Matrix3d A = in_plane<3>(s);
  Eigenpairs<3> pairs;
  pairs.n.setIdentity();
  const double negligible = 1e-18 * s.cwiseAbs().maxCoeff();
  constexpr int max_sweeps = 20;  // quadratic convergence: 4 or 5 are enough
  for (int sweep = 0; sweep < max_sweeps; ++sweep) {
    bool rotated = false;
    for (const auto& [p, q] : {std::pair{0, 1}, {0, 2}, {1, 2}}) {
      if (std::abs(A(p, q)) <= negligible) continue;
      rotate(A, pairs.n, p, q);
      rotated = true;
    }
    if (!rotated) break;
  }
  pairs.value = {A(0, 0), A(1, 1), A(2, 2)};
  return pairs;
}

template <>
Symmetric<3> compose<3>(const std::array<double, 3>& value, const Eigen::Matrix3d& n) {
  const Matrix<3> scaled = n * Eigen::Map<const Eigen::Vector3d>(value.data()).asDiagonal();
  return symmetric<3>(scaled * n.transpose());
}

}  // namespace gabion
