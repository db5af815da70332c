// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/mechanics/materials/lane_return.hpp"
#include "common/mechanics/materials/point_batch.hpp"

namespace gabion {

/// principal_update<3>() for four points of one material under Mohr-Coulomb or Tresca without a
/// tension cut-off: the same formulas with each choice made lane by lane, on axes in the order of
/// the principal values.
class SpaceReturn {
 public:
  /// @param keeps_gap  see MaterialState::gap
  SpaceReturn(const PrincipalMohrCoulomb& law, bool keeps_gap);

  /// Find P, what goes to `out` and, if `with_A`, A. False when a point has det(1 + H) <= 0 or no
  /// elastic state.
  bool update(PointBatch<3>& batch, bool with_A) const;
  /// Like update(), of the points that stay elastic under surfaces of their own. What `batch` holds
  /// of the others is undefined. @returns which points are elastic
  LaneMask update_elastic(PointBatch<3>& batch, const LaneStrength& surface, bool with_A) const;

 private:
  struct Trial;
  struct Returned;
  static Trial trial_of(const PointBatch<3>& batch);
  void store(const Trial& trial, const Returned& returned, PointBatch<3>& batch) const;
  Lanes shear_factor(const Trial& trial, const Returned& returned, int i, int j) const;
  void store_tangent(const Trial& trial, const Returned& returned, PointBatch<3>& batch) const;

  LaneReturn return_;
  bool keeps_gap_;
  double moduli_[LaneReturn::num_faces][9];  // d tau / d eps, row by row
};

}  // namespace gabion
