// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <deque>

#include "common/run/state.hpp"

namespace gabion {

/// Extrapolates the interface displacement with the polynomial through the last accepted states,
/// whatever their distances in time.
class Predictor {
 public:
  /// @param order  0, 1 or 2; lower while there are fewer states
  explicit Predictor(int order) : order_(order) {}

  /// @pre `time` is later than the state before
  void accept(double time, const Eigen::VectorXd& x);
  /// @pre at least one state was accepted
  Eigen::VectorXd predict(double time) const;
  /// Go on without the states before; one has to be accepted next.
  void forget() { states_.clear(); }
  void visit_state(StateVisitor& visitor);

 private:
  struct Accepted {
    double time = 0;  // [s]
    Eigen::VectorXd x;
  };
  int order_;
  std::deque<Accepted> states_;  // newest first
};

}  // namespace gabion
