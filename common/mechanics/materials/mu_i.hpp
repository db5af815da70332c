// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>

#include "common/mechanics/materials/apex_volume.hpp"
#include "common/mechanics/materials/stress_update.hpp"

namespace gabion {

struct MuIParameters {
  double lambda = 0;           ///< [Pa]
  double mu = 0;               ///< [Pa]
  double static_friction = 0;  ///< mu_s, sqrt(J2) over pressure at the onset of flow, > 0
  double limit_friction = 0;   ///< mu_2 of fast flow, >= mu_s
  double inertial_number = 0;  ///< I_0, at which the friction is half way between, > 0
  double grain_size = 0;       ///< d [m], > 0
  double grain_density = 0;    ///< rho_s of the grain itself [kg/m^3], > 0
  ApexVolume apex_volume = ApexVolume::gap;
};

/// Flow of one step from a trial state beyond the static friction.
struct GranularFlow {
  double shear = 0;        ///< engineering shear strain x of the flow
  double friction = 0;     ///< mu(I)
  double by_trial = 0;     ///< d sqrt(J2) / d sqrt(J2)_trial, from 0 to 1
  double by_pressure = 0;  ///< d sqrt(J2) / d P
};

/// Solve root - G x = P mu(I) for x > 0, with I = (x / dt) d sqrt(rho_s / P): a quadratic equation.
/// @param root      sqrt(J2) of the trial state [Pa], above mu_s P; with dt = 0 above mu_2 P
/// @param pressure  P [Pa], > 0; flow at constant volume does not change it
/// @param dt        [s], >= 0, also infinite
GranularFlow solve_granular_flow(const MuIParameters& law, double root, double pressure, double dt);

/// Hencky elasticity with dense granular flow: where sqrt(J2) exceeds mu_s P, it is mu(I) P with
///
///     mu(I) = mu_s + (mu_2 - mu_s) I / (I_0 + I) ,   I = rate d sqrt(rho_s / P)
///
/// and rate the engineering shear rate of the flow, which is isochoric. There is no tension: a
/// state without pressure is free of stress.
/// @see Jop, Forterre and Pouliquen (2006), doi:10.1038/nature04801
template <int dim>
class MuI {
 public:
  static constexpr bool is_elastic = false;
  explicit MuI(const MuIParameters& parameters) : parameters_(parameters) {}

  bool update(const PointContext& context, const Matrix<dim>& H, const MaterialState<dim>& state_n,
              StressUpdate<dim>& out, Tangent<dim>* A) const;
  /// The response after infinite time, when all flow has come to rest: friction is the static one.
  bool update(const Matrix<dim>& H, const MaterialState<dim>& state_n, StressUpdate<dim>& out,
              Tangent<dim>* A) const {
    return update({.dt = std::numeric_limits<double>::infinity()}, H, state_n, out, A);
  }
  bool symmetric_tangent() const { return false; }
  double p_wave_modulus() const { return parameters_.lambda + 2 * parameters_.mu; }
  double shear_modulus() const { return parameters_.mu; }

  const MuIParameters& parameters() const { return parameters_; }

 private:
  MuIParameters parameters_;
};

}  // namespace gabion
