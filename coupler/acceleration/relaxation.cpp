// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/acceleration/relaxation.hpp"

#include <algorithm>

namespace gabion {

void Aitken::begin_step() {
  omega_ = std::min(first_, omega_);
  r_last_.resize(0);
}

int Aitken::reset() {
  omega_ = first_;
  r_last_.resize(0);
  return 0;
}

void Aitken::rescale(const Eigen::VectorXd& ratio) {
  if (r_last_.size() > 0) r_last_.array() *= ratio.array();
}

Eigen::VectorXd Aitken::next(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde) {
  const Eigen::VectorXd r = x_tilde - x;
  if (r_last_.size() > 0) {
    const Eigen::VectorXd dr = r - r_last_;
    const double omega = -omega_ * r_last_.dot(dr) / dr.squaredNorm();
    if (omega > 0 && omega <= largest) omega_ = omega;  // false for NaN too
  }
  r_last_ = r;
  return x + omega_ * r;
}

}  // namespace gabion
