// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/mechanics/materials/mohr_coulomb_return.hpp"
#include "common/mechanics/materials/stress_update.hpp"
#include "common/mechanics/simd/lanes.hpp"

namespace gabion {

/// Three principal values of four points.
struct PrincipalLanes {
  Lanes x[3];

  Lanes& operator[](int k) { return x[k]; }
  const Lanes& operator[](int k) const { return x[k]; }
  Lanes sum() const { return x[0] + x[1] + x[2]; }
  Lanes squares() const { return x[0] * x[0] + x[1] * x[1] + x[2] * x[2]; }
};

inline PrincipalLanes choose(const LaneMask& mask, const PrincipalLanes& a,
                             const PrincipalLanes& b) {
  return {select(mask, a[0], b[0]), select(mask, a[1], b[1]), select(mask, a[2], b[2])};
}

// The functions of spectral.hpp for four values.
Lanes hencky_strain(const Lanes& e);
Lanes strain_from_hencky(const Lanes& eps);
Lanes hencky_slope(const Lanes& b_0, const Lanes& b_1);

/// Yield surfaces k tau_1 - tau_3 = strength of four points.
struct LaneStrength {
  Lanes k, strength;
};

/// Return to the planes, edges and apex of Mohr-Coulomb or Tresca without a tension cut-off: the
/// formulas of mohr_coulomb_return.hpp with each choice made lane by lane.
class LaneReturn {
 public:
  enum Face { elastic, plane, edge_12, edge_23, apex, num_faces };
  /// State after the return, in descending order.
  struct State {
    PrincipalLanes eps_e, plastic{};
    LaneMask on[num_faces]{};

    /// The face of the yield surface on which the stress of a lane lies.
    Face face(int lane) const {
      Face found = elastic;
      for (const Face other : {plane, edge_12, edge_23, apex}) {
        if (on[other][lane]) found = other;
      }
      return found;
    }
    YieldRegion region(int lane) const {
      const Face at = face(lane);
      return at == elastic ? YieldRegion::elastic
             : at == apex  ? YieldRegion::apex
                           : YieldRegion::shear;
    }
  };

  explicit LaneReturn(const PrincipalMohrCoulomb& law);

  const PrincipalMohrCoulomb& law() const { return law_; }
  /// See hencky_stress().
  PrincipalLanes stress(const PrincipalLanes& eps) const {
    const Lanes pressure = law_.lambda * eps.sum();
    return {pressure + 2 * law_.mu * eps[0], pressure + 2 * law_.mu * eps[1],
            pressure + 2 * law_.mu * eps[2]};
  }
  /// @param eps  trial Hencky strain, descending
  State apply(const PrincipalLanes& eps) const;
  /// Whether a trial state is beyond other surfaces than that of the law.
  LaneMask yields(const PrincipalLanes& eps, const LaneStrength& surface) const;
  /// The trial states as they are.
  static State elastic_state(const PrincipalLanes& eps) {
    State r;
    r.on[elastic] = ~LaneMask{};
    r.eps_e = eps;
    return r;
  }
  /// d tau / d eps of principal values in descending order.
  Eigen::Matrix3d moduli(Face face) const;

 private:
  void return_to_surface(const PrincipalLanes& eps, const PrincipalLanes& tau, State& r) const;

  PrincipalMohrCoulomb law_;
  double apex_strain_;                          // each principal elastic strain there
  double plane_stiffness_, edge_stiffness_[2];  // a . C c
};

}  // namespace gabion
