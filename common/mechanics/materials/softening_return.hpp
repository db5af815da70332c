// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>

#include "common/mechanics/materials/principal_surface.hpp"
#include "common/mechanics/materials/strength_curve.hpp"

namespace gabion {

/// Shear that a point has seen, and what strain adds to it.
struct ShearSoFar {
  double x = 0;                                         ///< of the curve
  double rate = 1;                                      ///< dx / d kappa
  double dt = std::numeric_limits<double>::infinity();  ///< of the step [s]
};

/// Constants of Mohr-Coulomb or Tresca at one state of softening, with their derivatives by the
/// softening strain kappa.
struct SoftenedConstants {
  PrincipalMohrCoulomb law;
  double tension_cutoff = no_cutoff;  ///< [Pa]
  double k_slope = 0, m_slope = 0, strength_slope = 0, cutoff_slope = 0;
};

/// Strength that grows with the logarithm of the shear rate,
///
///     c (1 + gain / ln 10 asinh(rate / (2 reference)))
///
/// by the share `gain` a decade far above the reference, not at all far below it.
struct RateGain {
  double gain = 0;       ///< share a decade; 0: none
  double reference = 0;  ///< engineering shear rate [1/s]
};

/// Mohr-Coulomb or Tresca whose strength depends on the shear since the virgin state.
struct SofteningSurface {
  double lambda = 0;         ///< [Pa]
  double mu = 0;             ///< [Pa]
  StrengthCurve curve = {};  ///< sin phi > 0 everywhere, or 0 everywhere: Tresca
  bool frictional = true;    ///< false: Tresca
  /// Tension cut-off by the cohesion, or no_cutoff.
  double cutoff_share = no_cutoff;
  RateGain rate_gain = {};  ///< Tresca alone

  /// Constants where nothing shears. @param x  shear of the curve  @param rate  dx / d kappa
  SoftenedConstants at(double x, double rate) const;
  /// Constants after an increment of kappa in a step.
  SoftenedConstants in_step(const ShearSoFar& before, double kappa) const;
};

/// A return to the surface as it is at its end.
struct SofteningReturn {
  PrincipalReturn state;
  SoftenedConstants constants;
  double kappa = 0;             ///< increment of kappa, >= 0
  Eigen::Vector3d eps_e_slope;  ///< d eps_e / d kappa at constant trial strain
  Eigen::Vector3d direction;    ///< d kappa / d eps of the plastic strain
  double slope = 1;             ///< of kappa - |..|, see solve_softening_return()
};

/// Solve, for the softening strain kappa that the step adds,
///
///     r(kappa) = kappa - sqrt(2/3) |dev eps_p(kappa)| = 0
///
/// with eps_p the plastic strain of the closed-form return at the constants of kappa. r is
/// continuous and negative at 0; Newton's method is kept between signs.
/// @returns false when no kappa was found, or when dr/dkappa <= 0 there or at the start: the
///          strength falls faster than the stress unloads
bool solve_softening_return(const SofteningSurface& surface, const ShearSoFar& before,
                            const Eigen::Vector3d& eps, const Eigen::Vector3d& tau_trial,
                            SofteningReturn& returned);

/// d tau / d eps of the return.
Eigen::Matrix3d softening_moduli(const SofteningReturn& returned);

/// Largest 1 - dr/dkappa of states on the surface whose compression is at most `pressure` [Pa],
/// over all faces and shears: from 1 on the strength falls faster than the stress unloads. It grows
/// as rate / mu at a constant Poisson's ratio.
double snap_back(const SofteningSurface& surface, double rate, double pressure);

}  // namespace gabion
