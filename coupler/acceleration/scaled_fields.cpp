// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/acceleration/scaled_fields.hpp"

#include "coupler/state_vectors.hpp"

namespace gabion {

namespace {
constexpr double taken_over = 10;  // change of a weight
}

ScaledFields::ScaledFields(std::unique_ptr<Acceleration> method,
                           const std::vector<Eigen::Index>& fields)
    : method_(std::move(method)),
      fields_(fields),
      weights_(Eigen::VectorXd::Ones(static_cast<Eigen::Index>(fields.size()))),
      sums_(Eigen::VectorXd::Zero(weights_.size())) {}

void ScaledFields::begin_step() {
  sums_.setZero();
  method_->begin_step();
}

Eigen::VectorXd ScaledFields::spread(const Eigen::VectorXd& of_fields) const {
  Eigen::Index size = 0;
  for (const Eigen::Index n : fields_) size += n;
  Eigen::VectorXd result(size);
  Eigen::Index at = 0;
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    result.segment(at, fields_[i]).setConstant(of_fields(static_cast<Eigen::Index>(i)));
    at += fields_[i];
  }
  return result;
}

void ScaledFields::update_weights(const Eigen::VectorXd& r) {
  const double all = r.stableNorm();
  if (!(all > 0)) return;
  Eigen::Index at = 0;
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    sums_(static_cast<Eigen::Index>(i)) += r.segment(at, fields_[i]).stableNorm() / all;
    at += fields_[i];
  }
  Eigen::VectorXd wanted = weights_;
  for (Eigen::Index i = 0; i < sums_.size(); ++i) {
    if (sums_(i) > 0) wanted(i) = 1 / sums_(i);
  }
  const Eigen::ArrayXd ratio = wanted.array() / weights_.array();
  const bool changed = ratio.maxCoeff() > taken_over || ratio.minCoeff() < 1 / taken_over;
  if (!first_step_ && !changed) return;
  method_->rescale(spread(ratio.matrix()));
  weights_ = wanted;
}

Eigen::VectorXd ScaledFields::next(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde) {
  update_weights(x_tilde - x);
  const Eigen::VectorXd scale = spread(weights_);
  return method_->next(scale.cwiseProduct(x), scale.cwiseProduct(x_tilde)).cwiseQuotient(scale);
}

void ScaledFields::end_step(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde) {
  const Eigen::VectorXd scale = spread(weights_);
  method_->end_step(scale.cwiseProduct(x), scale.cwiseProduct(x_tilde));
  first_step_ = false;
}

void ScaledFields::visit_state(StateVisitor& visitor) {
  visit_vector(visitor, "fields.weights", weights_);
  visitor.flag("fields.first_step", first_step_);
  method_->visit_state(visitor);
}

}  // namespace gabion
