// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/acceleration/scaled_fields.hpp"

#include <cmath>

namespace gabion {

namespace {
constexpr double taken_over = 10;  // change of the weight
}

ScaledFields::ScaledFields(std::unique_ptr<Acceleration> method, std::array<Eigen::Index, 2> sizes)
    : method_(std::move(method)), sizes_(sizes) {}

void ScaledFields::begin_step() {
  changes_.setZero();
  answers_.setZero();
  x_last_.resize(0);
  x_tilde_last_.resize(0);
  method_->begin_step();
}

Eigen::Array2d ScaledFields::squares(const Eigen::VectorXd& v) const {
  return {v.head(sizes_[0]).squaredNorm(), v.tail(sizes_[1]).squaredNorm()};
}

Eigen::VectorXd ScaledFields::scaled(Eigen::VectorXd v, double factor) const {
  v.head(sizes_[0]) *= factor;
  return v;
}

double ScaledFields::wanted_weight(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde) {
  const bool first = x_last_.size() == 0;
  if (!first) {
    changes_ += squares(x - x_last_);
    answers_ += squares(x_tilde - x_tilde_last_);
  }
  x_last_ = x;
  x_tilde_last_ = x_tilde;
  const Eigen::Array2d r = squares(x_tilde - x);
  if (first) return first_step_ && r.minCoeff() > 0 ? std::sqrt(r(1) / r(0)) : 0;
  if (!(changes_.minCoeff() > 0 && answers_.minCoeff() > 0)) return 0;
  return std::sqrt(std::sqrt(answers_(1) / changes_(0)) * std::sqrt(changes_(1) / answers_(0)));
}

void ScaledFields::update_weight(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde) {
  const double wanted = wanted_weight(x, x_tilde);
  if (!(wanted > 0 && std::isfinite(wanted))) return;
  const double ratio = wanted / weight_;
  const bool changed = ratio > taken_over || ratio < 1 / taken_over;
  if (!first_step_ && !changed) return;
  method_->rescale(scaled(Eigen::VectorXd::Ones(sizes_[0] + sizes_[1]), ratio));
  weight_ = wanted;
}

Eigen::VectorXd ScaledFields::next(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde) {
  update_weight(x, x_tilde);
  return scaled(method_->next(scaled(x, weight_), scaled(x_tilde, weight_)), 1 / weight_);
}

void ScaledFields::end_step(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde) {
  method_->end_step(scaled(x, weight_), scaled(x_tilde, weight_));
  first_step_ = false;
}

void ScaledFields::visit_state(StateVisitor& visitor) {
  visitor.real("fields.weight", weight_);
  visitor.flag("fields.first_step", first_step_);
  method_->visit_state(visitor);
}

}  // namespace gabion
