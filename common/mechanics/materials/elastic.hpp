// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/mechanics/materials/stress_update.hpp"

namespace gabion {

/// Small strain, sigma = lambda tr(eps) 1 + 2 mu eps, no change of geometry.
template <int dim>
struct LinearElastic {
  static constexpr bool is_elastic = true;
  double lambda = 0;  ///< [Pa]
  double mu = 0;      ///< [Pa]
  bool update(const Matrix<dim>& H, const MaterialState<dim>& state_n, StressUpdate<dim>& out,
              Tangent<dim>* A) const;
  bool symmetric_tangent() const { return true; }
  double p_wave_modulus() const { return lambda + 2 * mu; }
  double shear_modulus() const { return mu; }
};

/// tau = lambda ln(J) 1 + mu (b - 1).
template <int dim>
struct NeoHookean {
  static constexpr bool is_elastic = true;
  double lambda = 0;  ///< [Pa]
  double mu = 0;      ///< [Pa]
  bool update(const Matrix<dim>& H, const MaterialState<dim>& state_n, StressUpdate<dim>& out,
              Tangent<dim>* A) const;
  bool symmetric_tangent() const { return true; }
  double p_wave_modulus() const { return lambda + 2 * mu; }
  double shear_modulus() const { return mu; }
};

/// tau = lambda tr(eps) 1 + 2 mu eps with the Hencky strain eps = ln(b) / 2.
template <int dim>
struct HenckyElastic {
  static constexpr bool is_elastic = true;
  double lambda = 0;  ///< [Pa]
  double mu = 0;      ///< [Pa]
  bool update(const Matrix<dim>& H, const MaterialState<dim>& state_n, StressUpdate<dim>& out,
              Tangent<dim>* A) const;
  bool symmetric_tangent() const { return true; }
  double p_wave_modulus() const { return lambda + 2 * mu; }
  double shear_modulus() const { return mu; }
};

}  // namespace gabion
