// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <vector>

#include "coupler/acceleration/acceleration.hpp"

namespace gabion::test {

/// Numbers in [-1, 1) that are the same everywhere (Weyl's sequence).
class Sequence {
 public:
  explicit Sequence(int seed) : value_(0.5 + 0.1 * seed) {}
  double operator()() {
    value_ += 0.6180339887498949;
    value_ -= std::floor(value_);
    double scrambled = value_ * 9973.37;
    scrambled -= std::floor(scrambled);
    return 2 * scrambled - 1;
  }
  Eigen::VectorXd vector(Eigen::Index n) {
    Eigen::VectorXd v(n);
    for (double& entry : v) entry = (*this)();
    return v;
  }

 private:
  double value_;
};

/// x -> A x + b with A symmetric, eigenvalues -m/k, k = 1..n: the added-mass operator of a light
/// structure. In the eigenvectors' basis b_k = cos(k/2 + 0.3 s) in step s = 0, 1, ...: two shapes
/// that change their shares, as a load that moves along a wall.
class AffineMap {
 public:
  explicit AffineMap(double m, Eigen::Index n = 50) {
    Sequence sequence(3);
    Eigen::MatrixXd random(n, n);
    for (Eigen::Index j = 0; j < n; ++j) random.col(j) = sequence.vector(n);
    q_ = Eigen::HouseholderQR<Eigen::MatrixXd>(random).householderQ();
    Eigen::VectorXd eigenvalues(n);
    for (Eigen::Index k = 0; k < n; ++k) eigenvalues(k) = -m / static_cast<double>(k + 1);
    A_ = q_ * eigenvalues.asDiagonal() * q_.transpose();
    set_step(0);
  }

  void set_step(int s) {
    Eigen::VectorXd b(A_.rows());
    for (Eigen::Index k = 0; k < b.size(); ++k) b(k) = std::cos(0.5 * double(k + 1) + 0.3 * s);
    b_ = q_ * b;
  }
  Eigen::Index size() const { return A_.rows(); }
  Eigen::VectorXd operator()(const Eigen::VectorXd& x) const { return A_ * x + b_; }
  Eigen::VectorXd fixed_point() const {
    const auto n = A_.rows();
    return (Eigen::MatrixXd::Identity(n, n) - A_).partialPivLu().solve(b_);
  }

 private:
  Eigen::MatrixXd q_;
  Eigen::MatrixXd A_;
  Eigen::VectorXd b_;
};

/// Iterations that each of five steps needs until |r| <= 1e-8, starting from the solution of the
/// step before; `limit` where it needs more.
inline std::vector<int> iteration_counts(AffineMap map, Acceleration& acceleration, int limit = 200,
                                         int steps = 5) {
  std::vector<int> counts;
  Eigen::VectorXd x = Eigen::VectorXd::Zero(map.size());
  for (int s = 0; s < steps; ++s) {
    map.set_step(s);
    acceleration.begin_step();
    for (int k = 1;; ++k) {
      const Eigen::VectorXd x_tilde = map(x);
      if ((x_tilde - x).norm() <= 1e-8 || k == limit) {
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
