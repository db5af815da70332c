// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/step/predictor.hpp"

#include <cassert>

#include "coupler/state_vectors.hpp"

namespace gabion {

void Predictor::accept(double time, const Eigen::VectorXd& x) {
  assert(states_.empty() || time > states_.front().time);
  states_.push_front({time, x});
  if (static_cast<int>(states_.size()) > order_ + 1) states_.pop_back();
}

Eigen::VectorXd Predictor::predict(double time) const {
  assert(!states_.empty());
  // Newton's form, so that equal states are reproduced to the bit.
  Eigen::VectorXd result = states_[0].x;
  if (states_.size() < 2) return result;
  const double t0 = states_[0].time;
  const double t1 = states_[1].time;
  const Eigen::VectorXd slope = (states_[0].x - states_[1].x) / (t0 - t1);
  result += (time - t0) * slope;
  if (states_.size() < 3) return result;
  const double t2 = states_[2].time;
  const Eigen::VectorXd slope_before = (states_[1].x - states_[2].x) / (t1 - t2);
  result += (time - t0) * (time - t1) / (t0 - t2) * (slope - slope_before);
  return result;
}

void Predictor::visit_state(StateVisitor& visitor) {
  visit_vectors(
      visitor, "predictor.x", states_.size(), [&](std::size_t count) { states_.resize(count); },
      [&](std::size_t k) -> Eigen::VectorXd& { return states_[k].x; });
  std::vector<double> times;
  for (const Accepted& state : states_) times.push_back(state.time);
  visitor.reals("predictor.time", times);
  for (std::size_t k = 0; k < times.size(); ++k) states_[k].time = times[k];
}

}  // namespace gabion
