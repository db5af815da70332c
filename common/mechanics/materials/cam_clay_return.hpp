// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "common/mechanics/materials/stress_update.hpp"

namespace gabion {

struct CamClayParameters {
  double compression = 0;         ///< lambda, -d ln J / d ln P of virgin compression, > kappa
  double swelling = 0;            ///< kappa, -d ln J / d ln P of unloading, > 0
  double critical_ratio = 0;      ///< M, q / P at the critical state, > 0
  double poisson_ratio = 0;       ///< at the pressure for which the shear modulus of a point is set
  double reference_pressure = 0;  ///< P_r at zero elastic strain [Pa], > 0
  double attraction = 0;          ///< a, isotropic tension at the tip of the ellipse [Pa], > 0

  /// Shear modulus that goes with the bulk modulus P / kappa [Pa].
  double shear_modulus_at(double P) const {
    return 1.5 * (1 - 2 * poisson_ratio) / (1 + poisson_ratio) * P / swelling;
  }
  /// P at an elastic volumetric strain [Pa], and the strain at a P.
  double pressure_at(double volumetric) const {
    return reference_pressure * std::exp(-volumetric / swelling);
  }
  double strain_at(double P) const { return swelling * std::log(reference_pressure / P); }
};

/// Memory of a point, as InternalState has it.
struct CamClayMemory {
  double preconsolidation = 0;  ///< P_c, the other end of the ellipse [Pa], >= a
  double shear_modulus = 0;     ///< mu_0 [Pa]
};

/// Volumetric and distortional Hencky strain, eps_v = tr eps and eps_s = sqrt(2/3) |dev eps|.
struct StrainInvariants {
  double volumetric = 0;
  double distortion = 0;
};

/// Elastic state at the end of a step.
struct CamClayState {
  YieldRegion region = YieldRegion::elastic;
  double volumetric = 0;        ///< elastic
  double share = 1;             ///< of the trial deviator that is left
  double preconsolidation = 0;  ///< [Pa]
  double P = 0;                 ///< [Pa]
  /// d (p, q) / d (eps_v, eps_s) of the trial state, p = a - P the mean stress [Pa].
  Eigen::Matrix2d moduli = Eigen::Matrix2d::Zero();
};

/// Backward Euler step of modified Cam-Clay in invariants, P = a - p > 0 and q = 3 mu_0 eps_s:
///
///     f = q^2 / M^2 + P (P - P_c) <= 0 , associated ,  P = P_r exp(-eps_v / kappa) ,
///     P_c = P_c,n exp((eps_v - eps_v,trial) / (lambda - kappa))
///
/// A state that would end below P = a is set to the apex: the rest of its volume opens without
/// pressure, q is at most that of the ellipse, and P_c stays.
/// @returns whether it was solved; the state is undefined if not
bool cam_clay_step(const CamClayParameters& law, const CamClayMemory& start,
                   const StrainInvariants& trial, CamClayState& state);

}  // namespace gabion
