// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/acceleration/residual_jacobian.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>

#include "common/base/require.hpp"

namespace gabion {

namespace {

Eigen::MatrixXd start(Eigen::Index size, double relaxation) {
  return -Eigen::MatrixXd::Identity(size, size) / relaxation;
}

}  // namespace

ResidualJacobian::ResidualJacobian(const AccelerationSettings& settings, Eigen::Index size)
    : settings_(settings) {
  require<ConfigError>(
      size <= largest,
      "acceleration \"mvqn_residual\": found {} unknowns at the interfaces, allowed: at "
      "most {}, because its matrix is dense; \"mvqn\" has no such limit",
      size, largest);
  accepted_ = start(size, settings.relaxation);
}

void ResidualJacobian::add_pair(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde) {
  const Eigen::VectorXd r = x_tilde - x;
  if (x_last_.size() > 0 && x != x_last_) {
    changes_.push_front({r - r_last_, x - x_last_});
    if (static_cast<int>(changes_.size()) > settings_.max_columns) {
      changes_.pop_back();
      ++counters_.dropped_by_limit;
    }
  }
  r_last_ = r;
  x_last_ = x;
}

Eigen::MatrixXd ResidualJacobian::jacobian() const {
  if (changes_.empty()) return accepted_;
  const auto columns = static_cast<Eigen::Index>(changes_.size());
  Eigen::MatrixXd V(accepted_.rows(), columns);
  Eigen::MatrixXd dX(accepted_.rows(), columns);
  for (Eigen::Index k = 0; k < columns; ++k) {
    V.col(k) = changes_[static_cast<std::size_t>(k)].r;
    dX.col(k) = changes_[static_cast<std::size_t>(k)].x;
  }
  const Eigen::MatrixXd inverse = dX.completeOrthogonalDecomposition().pseudoInverse();
  return accepted_ + (V - accepted_ * dX) * inverse;
}

Eigen::VectorXd ResidualJacobian::next(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde) {
  counters_ = {};
  add_pair(x, x_tilde);
  counters_.columns = static_cast<int>(changes_.size());
  if (counters_.columns == 0) counters_.omega = settings_.relaxation;
  return x - jacobian().partialPivLu().solve(r_last_);
}

void ResidualJacobian::end_step(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde) {
  add_pair(x, x_tilde);
  accepted_ = jacobian();
  discard_step();
}

void ResidualJacobian::discard_step() {
  changes_.clear();
  r_last_.resize(0);
  x_last_.resize(0);
}

int ResidualJacobian::reset() {
  const auto forgotten = static_cast<int>(changes_.size());
  discard_step();
  accepted_ = start(accepted_.rows(), settings_.relaxation);
  return forgotten;
}

void ResidualJacobian::rescale(const Eigen::VectorXd& ratio) {
  accepted_ = (ratio.asDiagonal() * accepted_ * ratio.cwiseInverse().asDiagonal()).eval();
  for (Change& change : changes_) {
    change.r.array() *= ratio.array();
    change.x.array() *= ratio.array();
  }
  if (r_last_.size() == 0) return;
  r_last_.array() *= ratio.array();
  x_last_.array() *= ratio.array();
}

}  // namespace gabion
