// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>

#include "coupler/state_vectors.hpp"

namespace gabion {

/// Work of the nodal forces f on one side of the interfaces, step by step,
///
///     W = 1/2 (f_n + f_n+1) . (u_n+1 - u_n)    forces at the end of the step: trapezoidal rule
///     W = f_n+1 . (u_n+1 - u_n)                mean forces of the step
///
/// With Newmark's rule, beta = 1/4, this is exactly the change of energy of a linear side; the sum
/// over both sides vanishes when their displacements agree and the forces are mapped
/// conservatively. The values before the first step are f = 0 and u = 0, or where the run begins.
class InterfaceWork {
 public:
  /// @param start_weight  of each f_n: 1/2, or 0 of a mean force
  explicit InterfaceWork(Eigen::VectorXd start_weight) : start_weight_(std::move(start_weight)) {}

  /// Begin displaced. @param u  of the size of accept() [m]
  void start(const Eigen::VectorXd& u) {
    u_ = u;
    f_ = Eigen::VectorXd::Zero(u.size());
  }

  /// @param u, f  [m], [N] at the end of an accepted step, of equal and constant size
  /// @returns     W of this step [J] (2D: per metre of thickness)
  double accept(const Eigen::VectorXd& u, const Eigen::VectorXd& f) {
    if (u_.size() == 0) u_ = f_ = Eigen::VectorXd::Zero(u.size());
    const auto& w = start_weight_.array();
    const double work = (w * f_.array() + (1 - w) * f.array()).matrix().dot(u - u_);
    u_ = u;
    f_ = f;
    return work;
  }

  /// Names begin with `prefix`.
  void visit_state(StateVisitor& visitor, const std::string& prefix) {
    visit_vector(visitor, prefix + "u", u_);
    visit_vector(visitor, prefix + "f", f_);
  }

 private:
  Eigen::VectorXd start_weight_;
  Eigen::VectorXd u_;  // empty before the first step
  Eigen::VectorXd f_;
};

}  // namespace gabion
