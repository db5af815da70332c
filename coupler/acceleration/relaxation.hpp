// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "coupler/acceleration/acceleration.hpp"

namespace gabion {

/// x+ = x + omega r with a given omega; omega = 1 is the plain fixed-point (Gauss-Seidel)
/// iteration.
class Constant : public Acceleration {
 public:
  explicit Constant(double omega) : omega_(omega) {}

  void begin_step() override {}
  Eigen::VectorXd next(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde) override {
    return x + omega_ * (x_tilde - x);
  }
  void end_step(const Eigen::VectorXd&, const Eigen::VectorXd&) override {}
  void discard_step() override {}
  int reset() override { return 0; }
  void rescale(const Eigen::VectorXd&) override {}
  AccelerationCounters counters() const override { return {omega_}; }

 private:
  double omega_;
};

/// x+ = x + omega_k r_k with
///
///     omega_k = -omega_{k-1} r_{k-1} . (r_k - r_{k-1}) / |r_k - r_{k-1}|^2
///
/// Guarded: an omega that is not finite, not positive or above `largest` (the secant then points
/// away from a contraction) is replaced by the last good one. Each step starts from the last omega
/// of the step before, but not above the given first one.
/// @see Irons and Tuck (1969); Kuettler and Wall (2008)
class Aitken : public Acceleration {
 public:
  explicit Aitken(double first) : first_(first), omega_(first) {}

  void begin_step() override;
  Eigen::VectorXd next(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde) override;
  void end_step(const Eigen::VectorXd&, const Eigen::VectorXd&) override {}
  void discard_step() override { reset(); }
  int reset() override;
  void rescale(const Eigen::VectorXd& ratio) override;
  AccelerationCounters counters() const override { return {omega_}; }

  static constexpr double largest = 2;

 private:
  double first_;
  double omega_;
  Eigen::VectorXd r_last_;  // empty before the first iteration of a step
};

}  // namespace gabion
