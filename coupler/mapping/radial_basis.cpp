// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/mapping/radial_basis.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <cmath>

namespace gabion {

namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

// A direction in which a cluster extends less than this share of its size is left out of the
// polynomial.
constexpr double flat_share = 1e-3;

// A vertex within this share of a cluster's radius needs no cluster of its own.
constexpr double covered_share = 0.5;

/// One interpolant, with the region in which it counts.
class Cluster {
 public:
  Cluster(const Surface& from, const Vector3d& centre, const RadialBasisSettings& settings)
      : kernel_(settings.kernel),
        centre_(centre),
        vertices_(from.nearest_vertices(centre, settings.cluster_size)) {
    for (const std::int64_t v : vertices_) {
      x_.push_back(from.vertex(v));
      radius_ = std::max(radius_, (x_.back() - centre).norm());
    }
    radius_ *= 1 + 1e-9;
    unit_ = kernel_ == Kernel::thin_plate ? radius_ : settings.support.value();
    choose_axes();
    factorise();
  }

  const Vector3d& centre() const { return centre_; }
  double radius() const { return radius_; }
  const std::vector<std::int64_t>& vertices() const { return vertices_; }

  /// Weights of the vertices for the value at x, and whether they are good to 1e-9.
  bool weights(const Vector3d& x, VectorXd& result) const {
    const Eigen::Index n = size();
    VectorXd b(n + num_terms());
    for (Eigen::Index i = 0; i < n; ++i) b(i) = phi(x, x_[i]);
    b.tail(num_terms()) = terms(x);
    result = lu_.solve(b).head(n);
    return distinct_ && std::abs(result.sum() - 1) <= 1e-9;  // false for NaN
  }

 private:
  Eigen::Index size() const { return static_cast<Eigen::Index>(x_.size()); }
  Eigen::Index num_terms() const { return 1 + axes_.cols(); }

  double phi(const Vector3d& a, const Vector3d& b) const {
    return radial_function(kernel_, (a - b).norm() / unit_);
  }

  // Terms of the linear polynomial, scaled to the cluster's extent.
  VectorXd terms(const Vector3d& x) const {
    VectorXd values(num_terms());
    values(0) = 1;
    values.tail(axes_.cols()) = axes_.transpose() * (x - mean_);
    return values;
  }

  void choose_axes() {
    mean_ = Vector3d::Zero();
    for (const Vector3d& x : x_) mean_ += x / static_cast<double>(size());
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    for (const Vector3d& x : x_) covariance += (x - mean_) * (x - mean_).transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(covariance);
    const Vector3d extent = eigen.eigenvalues().cwiseMax(0).cwiseSqrt();  // ascending
    axes_.resize(3, 0);
    for (int d = 2; d >= 0; --d) {
      if (extent(d) <= flat_share * extent(2)) break;
      axes_.conservativeResize(3, axes_.cols() + 1);
      axes_.col(axes_.cols() - 1) = eigen.eigenvectors().col(d) / extent(d);
    }
  }

  void factorise() {
    const Eigen::Index n = size(), m = num_terms();
    MatrixXd A = MatrixXd::Zero(n + m, n + m);
    for (Eigen::Index i = 0; i < n; ++i) {
      for (Eigen::Index k = 0; k < n; ++k) {
        A(i, k) = phi(x_[i], x_[k]);
        distinct_ &= i == k || (x_[i] - x_[k]).norm() > 1e-12 * radius_;
      }
      A.block(i, n, 1, m) = terms(x_[i]).transpose();
      A.block(n, i, m, 1) = terms(x_[i]);
    }
    lu_.compute(A);
  }

  Kernel kernel_;
  Vector3d centre_;
  double radius_ = 0;
  double unit_ = 0;  // unit of length of the arguments of phi [m]
  std::vector<std::int64_t> vertices_;
  std::vector<Vector3d> x_;
  bool distinct_ = true;  // no vertex stands twice
  Vector3d mean_ = Vector3d::Zero();
  Eigen::Matrix3Xd axes_;  // axes of the polynomial, each of length one over the extent
  Eigen::PartialPivLU<MatrixXd> lu_;
};

double largest_extent(const Surface& surface) {
  Vector3d low = surface.vertex(0), high = low;
  for (std::int64_t v = 1; v < surface.num_vertices(); ++v) {
    low = low.cwiseMin(surface.vertex(v));
    high = high.cwiseMax(surface.vertex(v));
  }
  return (high - low).maxCoeff();
}

std::string refusal(const Surface& from, const Cluster& cluster,
                    const RadialBasisSettings& settings) {
  const Vector3d& c = cluster.centre();
  return fmt::format(
      "interface \"{}\": radial basis functions with a support of {:.3g} m on the {} vertices of "
      "the structure within {:.3g} m of ({}, {}, {}) have a singular system; allowed: each vertex "
      "once, a smaller coupling/mapping/support or a rougher kernel",
      from.name(), settings.support.value(), cluster.vertices().size(), cluster.radius(), c(0),
      c(1), c(2));
}

}  // namespace

double radial_function(Kernel kernel, double r) {
  if (kernel == Kernel::thin_plate) return r > 0 ? r * r * std::log(r) : 0;
  if (r >= 1) return 0;
  const double s = 1 - r, s4 = s * s * s * s;
  if (kernel == Kernel::wendland_c2) return s4 * (4 * r + 1);
  if (kernel == Kernel::wendland_c4) return s4 * s * s * ((35 * r + 18) * r + 3) / 3;
  return s4 * s4 * (((32 * r + 25) * r + 8) * r + 1);
}

Eigen::SparseMatrix<double, Eigen::RowMajor> radial_basis_weights(const Surface& from,
                                                                  const Surface& to,
                                                                  RadialBasisSettings settings) {
  if (!settings.support) settings.support = largest_extent(from);
  const std::int64_t num_to = to.num_vertices();
  std::vector<Eigen::Triplet<double>> entries;
  VectorXd weights, total = VectorXd::Zero(num_to);
  std::vector<bool> covered(static_cast<std::size_t>(num_to), false);
  for (std::int64_t c = 0; c < num_to; ++c) {
    if (covered[static_cast<std::size_t>(c)]) continue;
    const Cluster cluster(from, to.vertex(c), settings);
    for (const std::int64_t v : to.vertices_within(cluster.centre(), cluster.radius())) {
      const double distance = (to.vertex(v) - cluster.centre()).norm() / cluster.radius();
      if (distance <= covered_share) covered[static_cast<std::size_t>(v)] = true;
      const double share = radial_function(Kernel::wendland_c2, distance);
      if (share == 0) continue;
      total(v) += share;
      if (!cluster.weights(to.vertex(v), weights)) {
        throw ConfigError(refusal(from, cluster, settings));
      }
      for (Eigen::Index i = 0; i < weights.size(); ++i) {
        entries.emplace_back(v, cluster.vertices()[static_cast<std::size_t>(i)],
                             share * weights(i));
      }
    }
  }
  Eigen::SparseMatrix<double, Eigen::RowMajor> H(num_to, from.num_vertices());
  H.setFromTriplets(entries.begin(), entries.end());
  return total.cwiseInverse().asDiagonal() * H;
}

}  // namespace gabion
