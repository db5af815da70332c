// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <memory>

#include "coupler/acceleration/acceleration.hpp"

namespace gabion {

/// An acceleration of two fields at once, displacement u and force f, which have different units.
/// Each is a response to the other: u~ = S(f), f~ = M(u). Before the method sees them, u is
/// multiplied by
///
///     w = sqrt((|df~| / |du|) (|df| / |du~|))        d: change from one iteration to the next
///
/// a stiffness [N/m] with which a change of either field causes an answer of the same size. With
/// this weight the update of an exact Jacobian is no longer than the residual, as with one field:
/// the method may bound it (QuasiNewton). The squares are summed over the iterations of a step.
/// Before the first change the residuals stand in for them, w = |r_f| / |r_u|.
///
/// The weight follows every iteration of the first step; afterwards it is taken over when it would
/// change by more than a factor 10.
/// @see docs/theory/coupling.md, (C4); Uekermann (2016), section 3.2, for weights by residuals
class ScaledFields : public Acceleration {
 public:
  /// @param sizes  of both fields, displacement first
  ScaledFields(std::unique_ptr<Acceleration> method, std::array<Eigen::Index, 2> sizes);

  void begin_step() override;
  Eigen::VectorXd next(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde) override;
  void end_step(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde) override;
  void discard_step() override { method_->discard_step(); }
  int reset() override { return method_->reset(); }
  void rescale(const Eigen::VectorXd& ratio) override { method_->rescale(ratio); }
  AccelerationCounters counters() const override { return method_->counters(); }
  void visit_state(StateVisitor& visitor) override;

  double weight() const { return weight_; }  ///< of the displacement [N/m]

 private:
  /// |v|^2 of each field.
  Eigen::Array2d squares(const Eigen::VectorXd& v) const;
  /// Weight that follows from x and x_tilde and the iterations before. @returns 0: none yet
  double wanted_weight(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde);
  void update_weight(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde);
  /// v with its displacement multiplied by `factor`.
  Eigen::VectorXd scaled(Eigen::VectorXd v, double factor) const;

  std::unique_ptr<Acceleration> method_;
  std::array<Eigen::Index, 2> sizes_;
  double weight_ = 1;
  bool first_step_ = true;
  // The current step: sums of squares of changes of x and of x_tilde, and the last iteration.
  Eigen::Array2d changes_ = Eigen::Array2d::Zero();
  Eigen::Array2d answers_ = Eigen::Array2d::Zero();
  Eigen::VectorXd x_last_;  // empty before the first iteration
  Eigen::VectorXd x_tilde_last_;
};

}  // namespace gabion
