// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "common/mechanics/materials/stress_update.hpp"
#include "fem_solver/materials/hardening.hpp"
#include "fem_solver/materials/log_strain.hpp"

namespace gabion::fem {

/// Hencky elasticity with von Mises' yield condition and associated flow in the space of the
/// logarithmic strain E = 1/2 ln C, hardening isotropic by p and kinematic by the plastic strain
/// E_p (Prager); in uniaxial tension true stress over logarithmic strain:
///
///     T = lambda tr(E - E_p) 1 + 2 mu (E - E_p) ,   beta = 2/3 H_k E_p
///     sqrt(3/2) |dev T - beta| <= sigma_y(p) ,   dp = sqrt(2/3) |dE_p|
///
/// integrated by backward Euler (radial return).
template <int dim>
struct VonMises {
  static constexpr bool is_elastic = false;
  /// Numbers that a point remembers: E_p as a Symmetric, then p.
  static constexpr int history_size = symmetric_size<dim> + 1;

  double lambda = 0;             ///< [Pa]
  double mu = 0;                 ///< [Pa]
  double kinematic_modulus = 0;  ///< H_k [Pa], in terms of uniaxial tension
  Hardening hardening;

  /// See ConstitutiveLaw; H and the stress P refer to the stress-free configuration.
  /// @param history_n  accepted, history_size
  /// @param history    at the end of the step, history_size
  bool update(const Matrix<dim>& H, std::span<const double> history_n, std::span<double> history,
              StressUpdate<dim>& out, Tangent<dim>* A) const;
  /// T and its consistent derivative at the logarithmic strain E; histories as above.
  void log_stress(const Symmetric<dim>& E, std::span<const double> history_n,
                  std::span<double> history, LogStress<dim>& out) const;

  bool symmetric_tangent() const { return true; }
  double p_wave_modulus() const { return lambda + 2 * mu; }
  double shear_modulus() const { return mu; }

  /// T : dE_p summed up over the path to a state: of the yield stress over p, and what kinematic
  /// hardening stores [J/m^3].
  double plastic_work(std::span<const double> history) const;
};

}  // namespace gabion::fem
