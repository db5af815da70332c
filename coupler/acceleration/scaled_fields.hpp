// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "coupler/acceleration/acceleration.hpp"

namespace gabion {

/// An acceleration of several fields at once, displacement and force, which have different units:
/// field i is multiplied by
///
///     w_i = 1 / sum_k (|r_k,i| / |r_k|)        over the iterations k of a step (residual sum)
///
/// before the method sees it, so that all fields weigh alike in its scalar products. The weights
/// follow every iteration of the first step; afterwards they are taken over, for all fields
/// together, when one of them would change by more than a factor 10. The fields of a step whose
/// residual is zero keep their weight.
/// @see Uekermann (2016), section 3.2
class ScaledFields : public Acceleration {
 public:
  /// @param fields  sizes, one after the other
  ScaledFields(std::unique_ptr<Acceleration> method, const std::vector<Eigen::Index>& fields);

  void begin_step() override;
  Eigen::VectorXd next(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde) override;
  void end_step(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde) override;
  void discard_step() override { method_->discard_step(); }
  int reset() override { return method_->reset(); }
  void rescale(const Eigen::VectorXd& ratio) override { method_->rescale(ratio); }
  AccelerationCounters counters() const override { return method_->counters(); }
  void visit_state(StateVisitor& visitor) override;

  const Eigen::VectorXd& weights() const { return weights_; }  ///< one a field

 private:
  void update_weights(const Eigen::VectorXd& r);
  Eigen::VectorXd spread(const Eigen::VectorXd& of_fields) const;

  std::unique_ptr<Acceleration> method_;
  std::vector<Eigen::Index> fields_;
  Eigen::VectorXd weights_;
  Eigen::VectorXd sums_;  // sums over this step
  bool first_step_ = true;
};

}  // namespace gabion
