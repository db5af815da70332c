// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>

#include "coupler/acceleration/acceleration.hpp"

namespace gabion {

/// Multi-vector quasi-Newton on the residual itself, with a dense Jacobian J = dr/dx, for
/// comparison with results of the framework that calls this method MVQN:
///
///     J = J_prev + (V - J_prev dX) dX^+ ,   solve J (x+ - x) = -r
///
/// dX, V: differences of x and of r of the newest `max_columns` iterations of this step; J_prev: J
/// of the step before, -I / omega at the start. Memory grows with the square, work with the cube of
/// the number of unknowns; there is no filter. Take QuasiNewton for anything but the comparison.
/// @see docs/theory/coupling.md, (C8)
class ResidualJacobian : public Acceleration {
 public:
  static constexpr Eigen::Index largest = 2000;  ///< unknowns: 64 MB and some seconds an iteration

  /// @throws ConfigError  size > largest
  ResidualJacobian(const AccelerationSettings& settings, Eigen::Index size);

  void begin_step() override { discard_step(); }
  Eigen::VectorXd next(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde) override;
  void end_step(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde) override;
  void discard_step() override;
  int reset() override;
  void rescale(const Eigen::VectorXd& ratio) override;
  AccelerationCounters counters() const override { return counters_; }
  void visit_state(StateVisitor& visitor) override {
    visitor.reals("jacobian", {accepted_.data(), static_cast<std::size_t>(accepted_.size())});
  }

 private:
  struct Change {  // from one iteration to the next
    Eigen::VectorXd r;
    Eigen::VectorXd x;
  };
  void add_pair(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde);
  Eigen::MatrixXd jacobian() const;

  AccelerationSettings settings_;
  AccelerationCounters counters_;
  Eigen::MatrixXd accepted_;    // J_prev
  std::deque<Change> changes_;  // newest first
  Eigen::VectorXd r_last_;      // empty before the first iteration of a step
  Eigen::VectorXd x_last_;
};

}  // namespace gabion
