// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/run/state.hpp"

namespace gabion {

/// An orthonormal basis of the space of the secants v = Q s. All least-squares problems over any of
/// the secants, in any order, can be solved with the coordinates s alone; only a new secant and the
/// end of a step work on vectors of interface length.
class SecantBasis {
 public:
  Eigen::Index size() const { return static_cast<Eigen::Index>(q_.size()); }

  /// Make the basis span v too, and project r, in one sweep, since reading the basis takes the
  /// time:
  /// @param[in]  v      secant
  /// @param[in]  r      any other vector
  /// @param[out] s      coordinates of v, size() of them afterwards
  /// @param[out] t      coordinates of the projection of r, size() of them afterwards
  void extend(const Eigen::VectorXd& v, const Eigen::VectorXd& r, Eigen::VectorXd& s,
              Eigen::VectorXd& t);
  /// Coordinates of the projection of r.
  Eigen::VectorXd coordinates(const Eigen::VectorXd& r) const;
  /// sum += factor Q t for the first t.size() vectors of the basis.
  void add(double factor, const Eigen::VectorXd& t, Eigen::VectorXd& sum) const;

  /// Forget the vectors that came after the first `size`.
  void truncate(Eigen::Index size);
  /// Shrink to as many vectors as there are columns in `s` (no more than needed to span them),
  /// changing these coordinates.
  /// @param[in,out] s  size() rows
  void shrink(Eigen::MatrixXd& s);
  /// Make the basis span D v for all v that it spans, D = diag(ratio) > 0.
  /// @returns T such that the coordinates of D v are T s; upper triangular
  Eigen::MatrixXd rescale(const Eigen::VectorXd& ratio);
  void visit_state(StateVisitor& visitor);

 private:
  /// rest -= Q t in one sweep. @returns coordinates of what is left of the rest along the basis
  Eigen::VectorXd take_out(const Eigen::VectorXd& t, Eigen::VectorXd& rest) const;
  /// Q <- Q - (Q YT) Y^T, but for the first vectors, as many as Y has columns.
  void reflect(const Eigen::MatrixXd& Y, const Eigen::MatrixXd& YT);

  std::vector<Eigen::VectorXd> q_;
};

/// sum += factors[0] columns[0] + factors[1] columns[1] + ...
void add_combination(const std::vector<const Eigen::VectorXd*>& columns,
                     const std::vector<double>& factors, Eigen::VectorXd& sum);

}  // namespace gabion
