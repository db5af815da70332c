// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/mechanics/materials/stress_update.hpp"
#include "fem_solver/materials/log_strain.hpp"

namespace gabion::fem {

/// Stress update of a law that answers to the logarithmic strain; see ConstitutiveLaw.
/// @param log_stress  called with E and the LogStress to fill
/// @returns           false when det F <= 0
template <int dim, class LogLaw>
bool update_by_log_stress(const Matrix<dim>& H, const LogLaw& log_stress, StressUpdate<dim>& out,
                          Tangent<dim>* A) {
  out.J = 1 + determinant_minus_one<dim>(H);
  if (!(out.J > 0)) return false;
  LogStrain<dim> strain;
  if (!find_log_strain<dim>(twice_green_strain<dim>(H), strain)) return false;
  LogStress<dim> stress;
  log_stress(strain.E, stress);
  const GreenStress<dim> green =
      turned_to_green<dim>(strain, log_by_green<dim>(strain), stress, A != nullptr);
  const Matrix<dim> F = Matrix<dim>::Identity() + H;
  out.P.noalias() = F * strain_tensor<dim>(green.S);
  out.tau = symmetric<dim>(out.P * F.transpose());
  if constexpr (dim == 2) out.tau[2] = stress.T[2];
  out.energy = stress.energy;
  if (A) first_tangent<dim>(F, green, *A);
  return true;
}

}  // namespace gabion::fem
