// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/mechanics/materials/lanes.hpp"
#include "common/mechanics/materials/mohr_coulomb_return.hpp"
#include "common/mechanics/materials/stress_update.hpp"

namespace gabion {

/// Four points in plane strain, of which a law finds the stresses at once.
struct PlaneBatch {
  static constexpr int size = num_lanes;
  Matrix<2> H[size];
  const MaterialState<2>* state_n[size];
  StressUpdate<2> out[size];
  Tangent<2>* A[size];  ///< where they go, if wanted
};

/// principal_update() for four points of one material under Mohr-Coulomb or Tresca without a
/// tension cut-off, in plane strain: the same formulas with each choice made lane by lane.
class PlaneReturn {
 public:
  /// @param keeps_gap  see MaterialState::gap
  PlaneReturn(const PrincipalMohrCoulomb& law, bool keeps_gap);

  /// Fill out and, if `with_A`, A. False when a point has det(1 + H) <= 0 or no elastic state.
  bool update(PlaneBatch& batch, bool with_A) const;

 private:
  enum Face { elastic, plane, edge_12, edge_23, apex, num_faces };
  /// d tau / d eps of the two axes in the plane, row by row.
  using PlaneModuli = double[4];

  struct Trial;
  struct Returned;
  static Trial trial_of(const PlaneBatch& batch);
  Returned return_of(const Trial& trial) const;
  void return_to_surface(const Trial& trial, const Lanes (&tau)[3], Returned& returned) const;
  void store(const Trial& trial, const Returned& returned, PlaneBatch& batch) const;
  void store_tangent(const Trial& trial, const Returned& returned, PlaneBatch& batch) const;

  PrincipalMohrCoulomb law_;
  bool keeps_gap_;
  double apex_strain_;                          // each principal elastic strain there
  double plane_stiffness_, edge_stiffness_[2];  // a . C c
  PlaneModuli moduli_[num_faces][3];            // by the position of the axis out of the plane
};

}  // namespace gabion
