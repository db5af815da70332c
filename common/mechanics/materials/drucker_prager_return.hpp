// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "common/mechanics/materials/stress_update.hpp"

namespace gabion {

/// Drucker-Prager in principal axes: f = sqrt(J2) + eta p - strength with p the mean stress,
/// tension positive, and flow along the gradient of sqrt(J2) + eta_bar p.
struct PrincipalDruckerPrager {
  double lambda;    ///< [Pa]
  double mu;        ///< [Pa]
  double eta;       ///< > 0
  double eta_bar;   ///< 0 <= eta_bar <= eta
  double strength;  ///< of pure shear [Pa], >= 0

  double bulk() const { return lambda + 2 * mu / 3; }
};

/// State after the return, in the order of the trial strains.
struct ConeReturn {
  YieldRegion region;
  Eigen::Vector3d eps_e;      ///< elastic Hencky strain
  Eigen::Vector3d plastic;    ///< plastic strain of this step, trial minus elastic
  Eigen::Vector3d direction;  ///< n = s_trial / sqrt(J2_trial)
  double shrinkage;           ///< sqrt(J2) / sqrt(J2_trial)
};

/// sqrt(J2) of a principal deviator.
inline double shear_size(const Eigen::Vector3d& s) {
  return std::sqrt(0.5 * s.squaredNorm());
}

/// Closed-form return of a trial state outside the cone. The radial return with the multiplier
/// f / (mu + bulk eta eta_bar) stands as long as sqrt(J2) stays positive; otherwise the state lies
/// in the cone of the apex p = strength / eta.
///
/// @param eps        trial Hencky strain
/// @param tau_trial  trial Kirchhoff stress of eps [Pa]
/// @see de Souza Neto, Peric and Owen (2008), section 8.3, with one multiplier for both returns
inline ConeReturn return_to_cone(const PrincipalDruckerPrager& law, const Eigen::Vector3d& eps,
                                 const Eigen::Vector3d& tau_trial) {
  const double p = tau_trial.sum() / 3;
  const Eigen::Vector3d s = (tau_trial.array() - p).matrix();
  const double root = shear_size(s);
  const double multiplier =
      (root + law.eta * p - law.strength) / (law.mu + law.bulk() * law.eta * law.eta_bar);
  if (root > law.mu * multiplier) {
    const Eigen::Vector3d n = s / root;
    const Eigen::Vector3d plastic = (multiplier * (0.5 * n.array() + law.eta_bar / 3)).matrix();
    return {.region = YieldRegion::shear,
            .eps_e = eps - plastic,
            .plastic = plastic,
            .direction = n,
            .shrinkage = 1 - law.mu * multiplier / root};
  }
  const Eigen::Vector3d eps_e =
      Eigen::Vector3d::Constant(law.strength / law.eta / (3 * law.bulk()));
  return {.region = YieldRegion::apex,
          .eps_e = eps_e,
          .plastic = eps - eps_e,
          .direction = Eigen::Vector3d::Zero(),
          .shrinkage = 0};
}

/// d tau / d eps of the stress returned to the cone.
inline Eigen::Matrix3d return_moduli(const PrincipalDruckerPrager& law, const ConeReturn& cone) {
  const Eigen::Vector3d Ca = (law.mu * cone.direction.array() + law.eta * law.bulk()).matrix();
  const Eigen::Vector3d Cc = (law.mu * cone.direction.array() + law.eta_bar * law.bulk()).matrix();
  const double shrunk = 1 - cone.shrinkage;  // mu multiplier / sqrt(J2_trial)
  Eigen::Matrix3d D = -Cc / (law.mu + law.bulk() * law.eta * law.eta_bar) * Ca.transpose();
  D += shrunk * law.mu * cone.direction * cone.direction.transpose();
  D.array() += law.bulk() - cone.shrinkage * 2 * law.mu / 3;
  D.diagonal().array() += cone.shrinkage * 2 * law.mu;
  return D;
}

}  // namespace gabion
