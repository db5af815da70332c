// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/mechanics/materials/mohr_coulomb_return.hpp"

namespace gabion {

/// Elastic Hencky strain of principal stresses.
inline Eigen::Vector3d strain_of_stress(const PrincipalMohrCoulomb& law,
                                        const Eigen::Vector3d& tau) {
  const double volumetric = tau.sum() / (3 * law.lambda + 2 * law.mu);
  return (0.5 / law.mu * (tau.array() - law.lambda * volumetric)).matrix();
}

/// Return to the cut-off t_i <= T alone, which flows along its gradients (Rankine): as many of the
/// largest stresses stay at T as are beyond it after the return of the others.
inline PrincipalReturn return_to_tension(const PrincipalMohrCoulomb& law, double T,
                                         const Eigen::Vector3d& eps,
                                         const Eigen::Vector3d& tau_trial) {
  const double lambda = law.lambda, M = law.lambda + 2 * law.mu;
  Eigen::Vector3d eps_e = eps;
  eps_e[0] -= (tau_trial[0] - T) / M;
  if (lambda * eps_e.sum() + 2 * law.mu * eps_e[1] <= T)
    return {YieldFace::tension_1, eps_e, eps - eps_e};
  eps_e[0] = eps_e[1] = (T - lambda * eps[2]) / (2 * (lambda + law.mu));
  if (lambda * eps_e.sum() + 2 * law.mu * eps_e[2] <= T)
    return {YieldFace::tension_12, eps_e, eps - eps_e};
  eps_e.setConstant(T / (3 * lambda + 2 * law.mu));
  return {YieldFace::tension_123, eps_e, eps - eps_e};
}

/// Return to where shear planes and cut-off meet: t1 = T, t3 = k T - strength. On the line, eps_2
/// stays elastic; it ends where t2 meets t1 or t3.
inline PrincipalReturn return_to_shear_and_tension(const PrincipalMohrCoulomb& law, double T,
                                                   const Eigen::Vector3d& eps) {
  const double t3 = law.k * T - law.strength;
  const double nu = 0.5 * law.lambda / (law.lambda + law.mu), E = 2 * law.mu * (1 + nu);
  const double t2 = E * eps[1] + nu * (T + t3);
  const YieldFace face = t2 > T    ? YieldFace::corner_12
                         : t2 < t3 ? YieldFace::corner_23
                                   : YieldFace::shear_tension;
  const double kept = face == YieldFace::corner_12 ? T : face == YieldFace::corner_23 ? t3 : t2;
  const Eigen::Vector3d eps_e = strain_of_stress(law, {T, kept, t3});
  return {face, eps_e, eps - eps_e};
}

/// Closed-form return to Mohr-Coulomb or Tresca planes cut off at t_i <= T below their apex.
///
/// A return to the shear planes alone stands if it keeps t1 <= T, one to the cut-off alone if it
/// keeps the shear planes; otherwise both are active, on the line where they meet or at its ends.
///
/// @param shear_return  (law, eps, tau_trial) -> return to the shear planes without cut-off
/// @pre   T < strength / (k - 1), and the trial state is outside
inline PrincipalReturn return_to_cut_off(const PrincipalMohrCoulomb& law, double T,
                                         const Eigen::Vector3d& eps,
                                         const Eigen::Vector3d& tau_trial,
                                         const auto& shear_return) {
  const auto largest = [&](const PrincipalReturn& r) {
    return law.lambda * r.eps_e.sum() + 2 * law.mu * r.eps_e[0];
  };
  if (law.k * tau_trial[0] - tau_trial[2] > law.strength) {
    const PrincipalReturn shear = shear_return(law, eps, tau_trial);
    if (largest(shear) <= T) return shear;
  }
  if (tau_trial[0] > T) {
    const PrincipalReturn tension = return_to_tension(law, T, eps, tau_trial);
    const double t3 = law.lambda * tension.eps_e.sum() + 2 * law.mu * tension.eps_e[2];
    if (law.k * T - t3 <= law.strength) return tension;
  }
  return return_to_shear_and_tension(law, T, eps);
}

/// d tau / d eps of a return with active cut-off, off its isotropic corner.
inline Eigen::Matrix3d cut_off_moduli(const PrincipalMohrCoulomb& law, YieldFace face) {
  const double lambda = law.lambda, M = law.lambda + 2 * law.mu;
  const double E = law.mu * (3 * lambda + 2 * law.mu) / (lambda + law.mu);
  Eigen::Matrix3d D = Eigen::Matrix3d::Zero();
  if (face == YieldFace::tension_1) {
    const double coupled = lambda * (1 - lambda / M);
    D(1, 1) = D(2, 2) = M - lambda * lambda / M;
    D(1, 2) = D(2, 1) = coupled;
  } else if (face == YieldFace::tension_12) {
    D(2, 2) = E;
  } else if (face == YieldFace::shear_tension) {
    D(1, 1) = E;
  }
  return D;
}

}  // namespace gabion
