// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/acceleration/secant_block.hpp"

#include <Eigen/Dense>

namespace gabion {

SecantBlock::SecantBlock(const std::vector<Secant>& secants, double filter) {
  if (secants.empty()) return;
  const Eigen::Index n = secants.front().v.size();
  const Eigen::Index most = std::min<Eigen::Index>(n, static_cast<Eigen::Index>(secants.size()));
  q_.resize(n, most);
  w_.resize(n, most);
  r_ = Eigen::MatrixXd::Zero(most, most);
  Eigen::Index kept = 0;
  for (const Secant& secant : secants) {
    const double length = secant.v.norm();
    Eigen::VectorXd rest = secant.v;
    Eigen::VectorXd along = Eigen::VectorXd::Zero(kept);
    for (int pass = 0; pass < 2; ++pass) {  // the second pass removes the round-off of the first
      for (Eigen::Index j = 0; j < kept; ++j) {
        const double part = q_.col(j).dot(rest);
        rest -= part * q_.col(j);
        along(j) += part;
      }
    }
    const double across = rest.norm();
    if (kept == most || !(across > 0) || (kept > 0 && across < filter * length)) {
      ++dropped_;
      continue;
    }
    q_.col(kept) = rest / across;
    r_.col(kept).head(kept) = along;
    r_(kept, kept) = across;
    w_.col(kept) = secant.w;
    ++kept;
  }
  q_.conservativeResize(Eigen::NoChange, kept);
  w_.conservativeResize(Eigen::NoChange, kept);
  r_.conservativeResize(kept, kept);
}

void SecantBlock::apply(Eigen::VectorXd& r, Eigen::VectorXd& update) const {
  if (num_columns() == 0) return;
  const Eigen::VectorXd projection = q_.transpose() * r;
  const Eigen::VectorXd c = -r_.triangularView<Eigen::Upper>().solve(projection);
  const Eigen::VectorXd covered = q_ * projection;  // -V c
  update += w_ * c + covered;
  r -= covered;
}

}  // namespace gabion
