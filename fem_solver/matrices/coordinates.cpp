// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/matrices/coordinates.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

#include "fem_solver/matrices/symmetric_factor.hpp"

namespace gabion::fem {

Coordinates::Coordinates(const LinearModel& full) : full_(full) {}

Coordinates::Coordinates(const LinearModel& full, std::vector<int> kept, int num_modes)
    : full_(full), kept_(std::move(kept)), reduction_(craig_bampton(full_, kept_, num_modes)) {}

int Coordinates::of_unknown(int unknown) const {
  if (!reduction_) return unknown;
  const auto found = std::lower_bound(kept_.begin(), kept_.end(), unknown);
  assert(found != kept_.end() && *found == unknown);
  return static_cast<int>(found - kept_.begin());
}

double Coordinates::unknown(const Eigen::VectorXd& q, int unknown) const {
  return reduction_ ? reduction_->T.row(unknown).dot(q) : q[unknown];
}

Eigen::VectorXd Coordinates::unknowns(const Eigen::VectorXd& q) const {
  return reduction_ ? Eigen::VectorXd(reduction_->T * q) : q;
}

Eigen::VectorXd Coordinates::forces(const Eigen::VectorXd& f) const {
  return reduction_ ? Eigen::VectorXd(reduction_->T.transpose() * f) : f;
}

Eigen::VectorXd Coordinates::velocity(const Eigen::VectorXd& v) const {
  if (!reduction_ || v.isZero(0)) return Eigen::VectorXd(v.head(model().size()));
  return SymmetricFactor(model().M, model().unknowns, "reduced mass").solve(forces(full_.M * v));
}

}  // namespace gabion::fem
