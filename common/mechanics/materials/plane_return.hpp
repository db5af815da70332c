// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/mechanics/materials/lane_return.hpp"
#include "common/mechanics/materials/point_batch.hpp"

namespace gabion {

/// principal_update() for four points of one material under Mohr-Coulomb or Tresca without a
/// tension cut-off, in plane strain: the same formulas with each choice made lane by lane.
class PlaneReturn {
 public:
  /// @param keeps_gap  see MaterialState::gap
  PlaneReturn(const PrincipalMohrCoulomb& law, bool keeps_gap);

  /// Find P, what goes to `out` and, if `with_A`, A. False when a point has det(1 + H) <= 0 or no
  /// elastic state.
  bool update(PointBatch<2>& batch, bool with_A) const;
  /// Like update(), of the points that stay elastic under surfaces of their own. What `batch` holds
  /// of the others is undefined. @returns which points are elastic
  LaneMask update_elastic(PointBatch<2>& batch, const LaneStrength& surface, bool with_A) const;

 private:
  /// d tau / d eps of the two axes in the plane, row by row.
  using PlaneModuli = double[4];

  struct Trial;
  struct Returned;
  static Trial trial_of(const PointBatch<2>& batch);
  void store(const Trial& trial, const Returned& returned, PointBatch<2>& batch) const;
  void store_tangent(const Trial& trial, const Returned& returned, PointBatch<2>& batch) const;

  LaneReturn return_;
  PrincipalMohrCoulomb law_;
  bool keeps_gap_;
  PlaneModuli moduli_[LaneReturn::num_faces][3];  // by the position of the axis out of the plane
};

}  // namespace gabion
