// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

namespace gabion {

/// One secant: differences of two successive iterations of one step.
struct Secant {
  Eigen::VectorXd v;  ///< difference of r
  Eigen::VectorXd w;  ///< difference of x_tilde
};

/// Secants, newest first, with a QR factorisation of the v that survive the filter QR2: built from
/// the newest to the oldest by modified Gram-Schmidt (orthogonalised twice), a column whose part
/// orthogonal to the newer ones is shorter than `filter` times itself is dropped. The newest is
/// kept unless it is zero.
class SecantBlock {
 public:
  SecantBlock() = default;
  /// @param secants  newest first, equal lengths
  SecantBlock(const std::vector<Secant>& secants, double filter);

  int num_columns() const { return static_cast<int>(q_.cols()); }
  int num_dropped() const { return dropped_; }

  /// Least squares c = argmin |V c + r| over the kept columns. Subtracts the covered part from r
  /// and adds it to the update.
  ///
  /// @param[in,out] r       residual; becomes r + V c
  /// @param[in,out] update  W c - V c is added
  void apply(Eigen::VectorXd& r, Eigen::VectorXd& update) const;

 private:
  Eigen::MatrixXd q_;  // n x columns, orthonormal
  Eigen::MatrixXd r_;  // columns x columns, upper triangular
  Eigen::MatrixXd w_;  // n x columns
  int dropped_ = 0;
};

}  // namespace gabion
