// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <limits>

#include "common/mechanics/materials/apex_volume.hpp"
#include "common/mechanics/materials/stress_update.hpp"
#include "common/mechanics/materials/tension_cutoff_return.hpp"
#include "common/mechanics/materials/yield_tolerance.hpp"

namespace gabion {

/// Value of a tension cut-off that is never reached.
inline constexpr double no_cutoff = std::numeric_limits<double>::infinity();

inline YieldRegion region_of(YieldFace face) {
  switch (face) {
    case YieldFace::apex:
    case YieldFace::tension_123:
      return YieldRegion::apex;
    case YieldFace::tension_1:
    case YieldFace::tension_12:
      return YieldRegion::tension;
    case YieldFace::shear_tension:
    case YieldFace::corner_12:
    case YieldFace::corner_23:
      return YieldRegion::shear_and_tension;
    default:
      return YieldRegion::shear;
  }
}

/// The return of Mohr-Coulomb and Tresca for principal_update().
/// @tparam ShearReturn  return to the shear planes without cut-off
template <auto ShearReturn>
struct PrincipalSurface {
  using Return = PrincipalReturn;
  const PrincipalMohrCoulomb& law;
  ApexVolume apex_volume;
  double tension_cutoff;  // [Pa]

  double lambda() const { return law.lambda; }
  double mu() const { return law.mu; }
  bool keeps_gap() const { return apex_volume == ApexVolume::gap; }
  bool yields(const Eigen::Vector3d& eps, const Eigen::Vector3d& tau_trial) const {
    const double size =
        (law.k + 1) * (law.lambda + 2 * law.mu) * std::max(std::abs(eps[0]), std::abs(eps[2]));
    const double f = law.k * tau_trial[0] - tau_trial[2] - law.strength;
    return f > yield_tolerance * size || tau_trial[0] - tension_cutoff > yield_tolerance * size;
  }
  Return return_to_surface(const Eigen::Vector3d& eps, const Eigen::Vector3d& tau_trial) const {
    if (tension_cutoff == no_cutoff) return ShearReturn(law, eps, tau_trial);
    return return_to_cut_off(law, tension_cutoff, eps, tau_trial, ShearReturn);
  }
  YieldRegion region(const Return& returned) const { return region_of(returned.face); }
  Eigen::Matrix3d moduli(const Return& returned) const {
    if (region_of(returned.face) != YieldRegion::shear) return cut_off_moduli(law, returned.face);
    return return_moduli(law, returned.face);
  }
  double shear_factor(const Return& returned, int s, int t, double G, double difference) const {
    if (made_equal(returned.face, s, t)) return 0;
    const double change = returned.plastic[s] - returned.plastic[t];
    // the cut-off leaves pairs of stresses alone, which may be equal
    return change == 0 ? G : G - 2 * law.mu * change / difference;
  }
};

}  // namespace gabion
