// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>

#include "common/mechanics/materials/stress_update.hpp"

namespace gabion {

struct NewtonianParameters {
  double bulk_modulus = 0;         ///< K = rho c^2 [Pa], > 0
  double viscosity = 0;            ///< dynamic, mu [Pa s], >= 0
  double cavitation_pressure = 0;  ///< tension at which the fluid tears [Pa], >= 0
};

/// Weakly compressible Newtonian fluid: of its deformation it remembers the volume only.
///
///     tau = K theta 1 + 2 mu / dt J_n dev(eps) ,  theta = ln J ,  eps = ln(F F^T) / 2
///
/// with F and eps of the step, J the volume by that without stress, J_n that at the start. Where
/// K theta would exceed the cavitation pressure, it stays there and a gap opens, which has to close
/// before the pressure changes again. Viscous strain counts as plastic, so that its work is the
/// heat.
template <int dim>
class Newtonian {
 public:
  static constexpr bool is_elastic = false;
  explicit Newtonian(const NewtonianParameters& parameters) : parameters_(parameters) {}

  /// A step of no length has no viscous stress.
  bool update(const PointContext& context, const Matrix<dim>& H, const MaterialState<dim>& state_n,
              StressUpdate<dim>& out, Tangent<dim>* A) const;
  /// The response at rest: pressure alone.
  bool update(const Matrix<dim>& H, const MaterialState<dim>& state_n, StressUpdate<dim>& out,
              Tangent<dim>* A) const {
    return update({.dt = std::numeric_limits<double>::infinity()}, H, state_n, out, A);
  }
  bool symmetric_tangent() const { return true; }
  double p_wave_modulus() const { return parameters_.bulk_modulus; }
  double shear_modulus() const { return 0; }
  double viscosity() const { return parameters_.viscosity; }

  const NewtonianParameters& parameters() const { return parameters_; }

 private:
  NewtonianParameters parameters_;
};

}  // namespace gabion
