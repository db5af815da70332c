// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace gabion::test {

/// Derivative of f at x by central differences of fourth order with step h.
/// @param f  VectorXd -> VectorXd
/// @returns f.size() x x.size()
template <class Function>
Eigen::MatrixXd difference_tangent(const Function& f, const Eigen::VectorXd& x, double h) {
  Eigen::MatrixXd tangent(f(x).size(), x.size());
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    const auto at = [&](double s) {
      Eigen::VectorXd shifted = x;
      shifted[k] += s * h;
      return Eigen::VectorXd(f(shifted));
    };
    tangent.col(k) = (8 * (at(1) - at(-1)) - (at(2) - at(-2))) / (12 * h);
  }
  return tangent;
}

/// Largest entry of `tangent` minus the difference tangent, relative to the latter's largest entry.
template <class Function>
double tangent_error(const Function& f, const Eigen::VectorXd& x, const Eigen::MatrixXd& tangent,
                     double h) {
  const Eigen::MatrixXd reference = difference_tangent(f, x, h);
  return (tangent - reference).cwiseAbs().maxCoeff() / reference.cwiseAbs().maxCoeff();
}

}  // namespace gabion::test
