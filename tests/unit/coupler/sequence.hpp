// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cmath>

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

}  // namespace gabion::test
