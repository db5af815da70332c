// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/mechanics/materials/stress_update.hpp"

namespace gabion {

struct HerschelBulkleyParameters {
  double lambda = 0;        ///< [Pa]
  double mu = 0;            ///< [Pa]
  double yield_stress = 0;  ///< tau_y, in simple shear [Pa], >= 0
  double consistency = 0;   ///< K [Pa s^n], > 0
  double flow_index = 1;    ///< n, 0.1 <= n <= 2; 1: Bingham
};

/// Flow of one step from a trial state beyond the yield stress.
struct ViscousFlow {
  double shear = 0;  ///< engineering shear strain x of the flow
  /// d sqrt(J2) / d sqrt(J2)_trial, from 0 (no viscosity) to 1 (elastic).
  double slope = 0;
};

/// Solve mu x + K (x / dt)^n = excess for x >= 0.
/// @param excess  sqrt(J2) of the trial state beyond the yield stress [Pa], > 0
/// @param dt      [s], > 0
/// @returns whether it was solved; flow is undefined if not
bool solve_viscous_flow(const HerschelBulkleyParameters& law, double excess, double dt,
                        ViscousFlow& flow);

/// Hencky elasticity with a fluid of Herschel and Bulkley in shear: where sqrt(J2) exceeds
/// yield_stress, it is yield_stress + consistency * rate^flow_index, with rate the engineering
/// shear rate of the flow. Flow is isochoric; pressure and isotropic tension stay elastic.
template <int dim>
class HerschelBulkley {
 public:
  static constexpr bool is_elastic = false;
  explicit HerschelBulkley(const HerschelBulkleyParameters& parameters) : parameters_(parameters) {}

  bool update(const PointContext& context, const Matrix<dim>& H, const MaterialState<dim>& state_n,
              StressUpdate<dim>& out, Tangent<dim>* A) const;
  /// The instantaneous response: nothing flows without time, so it is the elastic one.
  bool update(const Matrix<dim>& H, const MaterialState<dim>& state_n, StressUpdate<dim>& out,
              Tangent<dim>* A) const {
    return update({.dt = 0}, H, state_n, out, A);
  }
  bool symmetric_tangent() const { return true; }
  double p_wave_modulus() const { return parameters_.lambda + 2 * parameters_.mu; }
  double shear_modulus() const { return parameters_.mu; }

  const HerschelBulkleyParameters& parameters() const { return parameters_; }

 private:
  HerschelBulkleyParameters parameters_;
};

}  // namespace gabion
