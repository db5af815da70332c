// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <vector>

#include "coupler/acceleration/acceleration.hpp"

namespace gabion::test {

/// x -> A x + b with A symmetric, eigenvalues -m/k, k = 1..n: the added-mass operator of a light
/// structure. Its eigenvectors are those of a string, sin(k pi y), and the load in step s = 0, 1,
/// ... is b(y) = sin(pi y) + cos(y + s): a steady share, and one that moves along the string.
class AffineMap {
 public:
  explicit AffineMap(double m, Eigen::Index n = 50) : A_(n, n), b_(n) {
    const double pi = std::acos(-1.0);
    Eigen::MatrixXd modes(n, n);
    Eigen::VectorXd eigenvalues(n);
    for (Eigen::Index k = 0; k < n; ++k) {
      for (Eigen::Index i = 0; i < n; ++i) {
        modes(i, k) = std::sqrt(2.0 / double(n + 1)) * std::sin(pi * double(k + 1) * place(i));
      }
      eigenvalues(k) = -m / static_cast<double>(k + 1);
    }
    A_ = modes * eigenvalues.asDiagonal() * modes.transpose();
    set_step(0);
  }

  void set_step(int s) {
    for (Eigen::Index i = 0; i < size(); ++i) {
      b_(i) = std::sin(std::acos(-1.0) * place(i)) + std::cos(place(i) + s);
    }
  }
  Eigen::Index size() const { return A_.rows(); }
  Eigen::VectorXd operator()(const Eigen::VectorXd& x) const { return A_ * x + b_; }
  Eigen::VectorXd fixed_point() const {
    const auto n = A_.rows();
    return (Eigen::MatrixXd::Identity(n, n) - A_).partialPivLu().solve(b_);
  }

 private:
  double place(Eigen::Index i) const { return double(i + 1) / double(size() + 1); }  // y in (0, 1)

  Eigen::MatrixXd A_;
  Eigen::VectorXd b_;
};

/// Iterations that each of five steps needs until |r| <= 1e-8 |x_tilde|, starting from the
/// solution of the step before; `limit` where it needs more.
inline std::vector<int> iteration_counts(AffineMap map, Acceleration& acceleration, int limit = 200,
                                         int steps = 5) {
  std::vector<int> counts;
  Eigen::VectorXd x = Eigen::VectorXd::Zero(map.size());
  for (int s = 0; s < steps; ++s) {
    map.set_step(s);
    acceleration.begin_step();
    for (int k = 1;; ++k) {
      const Eigen::VectorXd x_tilde = map(x);
      if ((x_tilde - x).norm() <= 1e-8 * x_tilde.norm() || k == limit) {
        acceleration.end_step(x, x_tilde);
        x = x_tilde;
        counts.push_back(k);
        break;
      }
      x = acceleration.next(x, x_tilde);
    }
  }
  return counts;
}

}  // namespace gabion::test
