// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "common/mechanics/materials/cam_clay_return.hpp"
#include "common/mechanics/materials/stress_update.hpp"

namespace gabion {

/// Modified Cam-Clay at finite strain, in Kirchhoff stresses: elasticity that conserves energy,
///
///     W = kappa P_r exp(-eps_v / kappa) + a eps_v + 3/2 mu_0 eps_s^2
///
/// with a bulk modulus P / kappa that grows with the pressure and a shear modulus that each point
/// keeps, and the ellipse of cam_clay_step(), a circle in the deviatoric plane. The soil always
/// has a pressure: at zero elastic strain it is P_r, and its density and volume are those of that
/// state. A point takes its preconsolidation and its shear modulus from its initial stress.
/// @see Borja and Tamagnini (1998), doi:10.1016/S0045-7825(97)00141-2
template <int dim>
class CamClay {
 public:
  static constexpr bool is_elastic = false;
  /// It is a ContextualLaw for its memory alone.
  static constexpr bool depends_on_time = false;
  /// InternalState: P_c and mu_0, as CamClayMemory.
  static constexpr std::array internal_names = {"preconsolidation", "shear_modulus"};
  explicit CamClay(const CamClayParameters& parameters) : parameters_(parameters) {}

  bool update(const PointContext& context, const Matrix<dim>& H, const MaterialState<dim>& state_n,
              StressUpdate<dim>& out, Tangent<dim>* A) const;
  /// Update of soil that is normally consolidated at the reference pressure.
  bool update(const Matrix<dim>& H, const MaterialState<dim>& state_n, StressUpdate<dim>& out,
              Tangent<dim>* A) const {
    const double P = parameters_.reference_pressure;
    return update({.internal = {P, parameters_.shear_modulus_at(P)}}, H, state_n, out, A);
  }
  bool symmetric_tangent() const { return false; }
  /// Elastic modulus of P waves at the reference pressure [Pa].
  double p_wave_modulus() const {
    return parameters_.reference_pressure / parameters_.swelling + 4 * shear_modulus() / 3;
  }
  double shear_modulus() const {
    return parameters_.shear_modulus_at(parameters_.reference_pressure);
  }
  /// Elastic, of a point in its present state [Pa].
  double p_wave_modulus_at(const MaterialState<dim>& state, const InternalState& internal) const;
  /// phi of triaxial compression at the critical state [rad].
  double friction_angle() const {
    return std::asin(3 * parameters_.critical_ratio / (6 + parameters_.critical_ratio));
  }

  const CamClayParameters& parameters() const { return parameters_; }

 private:
  CamClayParameters parameters_;
};

}  // namespace gabion
