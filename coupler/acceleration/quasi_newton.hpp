// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "coupler/acceleration/acceleration.hpp"
#include "coupler/acceleration/filter.hpp"
#include "coupler/acceleration/secant_basis.hpp"

namespace gabion {

/// Differences of two successive iterations of one step.
struct Secant {
  Eigen::VectorXd s;      ///< difference of r: coordinates in the basis, which may have grown
  Eigen::VectorXd w;      ///< difference of x_tilde
  std::int64_t step = 0;  ///< number of the step, among steps that had secants
  bool dropped = false;   ///< in the current step; permanently once that is accepted
};

/// Notices that the iterations of a step make no progress, and keeps their best pair.
class ProgressWatch {
 public:
  static constexpr int patience = 5;     ///< iterations without a new smallest residual
  static constexpr double growth = 100;  ///< residual over the smallest one at which it stops

  void begin_step();
  /// Take in the next pair. @returns whether the patience or the growth is used up
  bool fails(const Eigen::VectorXd& x_tilde, const Eigen::VectorXd& r);
  void rescale(const Eigen::VectorXd& ratio);
  const Eigen::VectorXd& best_r() const { return best_r_; }
  const Eigen::VectorXd& best_x_tilde() const { return best_x_tilde_; }

 private:
  Eigen::VectorXd best_r_;  // empty before the first iteration of a step
  Eigen::VectorXd best_x_tilde_;
  int since_best_ = 0;
};

/// Interface quasi-Newton with an inverse Jacobian from differences of iterations:
///
///     c  = argmin |V c + r|      over the columns of this and of earlier steps
///     x+ = x + (W - V) c + beta (r + V c)         (beta = 1: x+ = x_tilde + W c)
///
/// Without any column x+ = x + omega r. Since earlier columns mislead where contact has changed, no
/// update is longer than twice the residual. This is IQN-ILS, and also the multi-vector update that
/// keeps the secant equations of earlier steps, N V_prev = W_prev: the two are equal
/// (docs/theory/coupling.md, (C8)).
/// @see Degroote, Bathe, Vierendeels (2009); Bogaers et al. (2014) for the multi-vector idea; Gay,
///      Schnabel (1978) for updates that keep earlier secants
class QuasiNewton : public Acceleration {
 public:
  explicit QuasiNewton(const AccelerationSettings& settings)
      : settings_(settings), filter_(settings.filter) {}

  void begin_step() override { discard_step(); }
  Eigen::VectorXd next(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde) override;
  void end_step(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde) override;
  void discard_step() override;
  int reset() override;
  void rescale(const Eigen::VectorXd& ratio) override;
  AccelerationCounters counters() const override { return counters_; }
  void visit_state(StateVisitor& visitor) override;

 private:
  /// Take in the pair; t: coordinates of its residual.
  void add_pair(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde, Eigen::VectorXd& t);
  /// Remove from a residual the part in the span of the columns. Columns that do not pass the
  /// filter are marked as dropped.
  /// @param[in,out] t  coordinates of r; becomes those of r + V c
  /// @param[out]    c  of each secant; not set where it is dropped
  void cover(Eigen::VectorXd& t, Eigen::VectorXd& c);
  /// Continue with the default filter from the best pair, when the filter of the settings makes no
  /// progress.
  /// @returns false: it is the default already
  bool fall_back();
  void limit_columns();
  Eigen::VectorXd shortened(const Eigen::VectorXd& x, const Eigen::VectorXd& next_x) const;
  void forget_old_steps();
  int num_in_use() const;

  AccelerationSettings settings_;
  AccelerationCounters counters_;
  Filter filter_;  // filter in use

  ProgressWatch watch_;
  SecantBasis basis_;
  std::deque<Secant> secants_;  // newest first
  // Cached QR factorisation of the secants in use: extended while secants are only added, made anew
  // otherwise. Each step begins without it, so that a restarted run gives the same bits.
  std::optional<FilteredLeastSquares> factored_;
  std::size_t num_factored_ = 0;  // secants, dropped ones too, when it was last brought up to date
  Eigen::Index size_accepted_ = 0;  // size of the basis when the step began
  std::int64_t step_ = 0;
  Eigen::VectorXd r_last_;  // empty before the first iteration of a step
  Eigen::VectorXd x_tilde_last_;
};

}  // namespace gabion
