// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <vector>

#include "coupler/acceleration/acceleration.hpp"
#include "coupler/acceleration/secant_block.hpp"

namespace gabion {

/// What both quasi-Newton methods share: the secants of the step under way, and
///
///     x+ = x + (W - V) c + beta (r + V c)         (beta = 1: x+ = x_tilde + W c)
///
/// where the methods differ in how c follows from the secants of this and of earlier steps.
/// Without any secant x+ = x + omega r.
class QuasiNewton : public Acceleration {
 public:
  explicit QuasiNewton(const AccelerationSettings& settings) : settings_(settings) {}

  void begin_step() override;
  Eigen::VectorXd next(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde) override;
  void end_step(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde) override;
  void discard_step() override { begin_step(); }
  void reset() override;
  AccelerationCounters counters() const override { return counters_; }

 protected:
  /// Take the covered part out of r and add W c - V c to the update.
  virtual void apply(const std::vector<Secant>& current, Eigen::VectorXd& r,
                     Eigen::VectorXd& update) = 0;
  /// Keep the secants of an accepted step.
  virtual void remember(const std::vector<Secant>& current) = 0;
  virtual void forget() = 0;

  AccelerationSettings settings_;
  AccelerationCounters counters_;

 private:
  void add_pair(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde);

  std::vector<Secant> current_;  // of the step under way, newest first
  Eigen::VectorXd r_last_;       // empty before the first iteration of a step
  Eigen::VectorXd x_tilde_last_;
};

/// Interface quasi-Newton with inverse Jacobian from a least-squares model: one least-squares
/// problem over the secants of this step and of the last `history` steps.
/// @see Degroote, Bathe, Vierendeels (2009)
class IqnIls : public QuasiNewton {
 public:
  using QuasiNewton::QuasiNewton;

 protected:
  void apply(const std::vector<Secant>& current, Eigen::VectorXd& r,
             Eigen::VectorXd& update) override;
  void remember(const std::vector<Secant>& current) override;
  void forget() override { earlier_.clear(); }

 private:
  std::deque<std::vector<Secant>> earlier_;  // newest step first
};

/// Multi-vector inverse Jacobian without a matrix: the residual is projected on the secants of this
/// step, what they leave over on those of the step before, and so on. With unlimited history and
/// no filter equal to the dense update N = N_prev + (W - N_prev V) V^+, x+ = x_tilde - N r.
/// @see Bogaers et al. (2014) for the multi-vector idea, Spenke et al. (2020) for the product form
class Mvqn : public QuasiNewton {
 public:
  using QuasiNewton::QuasiNewton;

 protected:
  void apply(const std::vector<Secant>& current, Eigen::VectorXd& r,
             Eigen::VectorXd& update) override;
  void remember(const std::vector<Secant>& current) override;
  void forget() override { earlier_.clear(); }

 private:
  std::deque<SecantBlock> earlier_;  // newest step first
};

}  // namespace gabion
