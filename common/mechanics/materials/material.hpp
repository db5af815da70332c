// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <variant>

#include "common/base/config_reader.hpp"
#include "common/mechanics/tensor.hpp"

namespace gabion {

/// History of one material point. Finite-strain laws keep e = b_e - 1 (b_e elastic left
/// Cauchy-Green tensor), which resolves strains far below 1e-8; the small-strain law keeps the
/// accumulated strain in `e`.
template <int dim>
struct MaterialState {
  Symmetric<dim> e = Symmetric<dim>::Zero();
  double plastic_strain = 0;  ///< accumulated norm of the plastic Hencky strain increments
};

/// Result of one stress update.
template <int dim>
struct StressUpdate {
  /// First Piola-Kirchhoff stress with respect to the configuration of `state_n`, per unit of the
  /// volume in which the material is free of stress: P = tau (1 + H)^-T  [Pa].
  Matrix<dim> P;
  Symmetric<dim> tau;  ///< Kirchhoff stress [Pa]
  MaterialState<dim> state;
  double J = 1;            ///< det(1 + H), volume ratio of this step
  double energy = 0;       ///< elastic energy per unit of stress-free volume [J/m^3]
  bool plastic = false;    ///< the yield condition is active
  double dissipation = 0;  ///< tau : plastic strain of the step, per stress-free volume [J/m^3]
};

// Contract of a material law (a value: parameters and one const update):
//
//   /// @param H        displacement gradient of the step, du_i / dX_J, X at state_n
//   /// @param state_n  accepted history
//   /// @param out      filled
//   /// @param A        null, or filled with the exact consistent dP/dH
//   /// @returns false when det(1 + H) <= 0 (out is then undefined)
//   bool update(const Matrix<dim>& H, const MaterialState<dim>& state_n, StressUpdate<dim>& out,
//               Tangent<dim>* A) const;
//   bool symmetric_tangent() const;      // A(iJ,kL) == A(kL,iJ) for every state
//   double p_wave_modulus() const;       // M = lambda + 2 mu at zero strain [Pa]
//
// For a total Lagrangian solver state_n is the virgin state and H the total displacement gradient.

/// Small strain, sigma = lambda tr(eps) 1 + 2 mu eps, no change of geometry.
template <int dim>
struct LinearElastic {
  double lambda = 0;  ///< [Pa]
  double mu = 0;      ///< [Pa]
  bool update(const Matrix<dim>& H, const MaterialState<dim>& state_n, StressUpdate<dim>& out,
              Tangent<dim>* A) const;
  bool symmetric_tangent() const { return true; }
  double p_wave_modulus() const { return lambda + 2 * mu; }
};

/// tau = lambda ln(J) 1 + mu (b - 1).
template <int dim>
struct NeoHookean {
  double lambda = 0;  ///< [Pa]
  double mu = 0;      ///< [Pa]
  bool update(const Matrix<dim>& H, const MaterialState<dim>& state_n, StressUpdate<dim>& out,
              Tangent<dim>* A) const;
  bool symmetric_tangent() const { return true; }
  double p_wave_modulus() const { return lambda + 2 * mu; }
};

/// tau = lambda tr(eps) 1 + 2 mu eps with the Hencky strain eps = ln(b) / 2.
template <int dim>
struct HenckyElastic {
  double lambda = 0;  ///< [Pa]
  double mu = 0;      ///< [Pa]
  bool update(const Matrix<dim>& H, const MaterialState<dim>& state_n, StressUpdate<dim>& out,
              Tangent<dim>* A) const;
  bool symmetric_tangent() const { return true; }
  double p_wave_modulus() const { return lambda + 2 * mu; }
};

/// Hencky elasticity with non-associated Mohr-Coulomb plasticity in principal Kirchhoff stresses,
/// tension positive: f = k t1 - t3 - 2 c sqrt(k), k = (1 + sin phi) / (1 - sin phi).
template <int dim>
class MohrCoulomb {
 public:
  /// @param lambda, mu      [Pa]
  /// @param friction_angle  phi [rad], 0 < phi < pi/2
  /// @param dilation_angle  psi [rad], 0 <= psi <= phi
  /// @param cohesion        c [Pa], >= 0
  MohrCoulomb(double lambda, double mu, double friction_angle, double dilation_angle,
              double cohesion);
  bool update(const Matrix<dim>& H, const MaterialState<dim>& state_n, StressUpdate<dim>& out,
              Tangent<dim>* A) const;
  bool symmetric_tangent() const { return dilation_angle_ == friction_angle_; }
  double p_wave_modulus() const { return lambda_ + 2 * mu_; }

  double lambda() const { return lambda_; }
  double mu() const { return mu_; }
  double friction_angle() const { return friction_angle_; }
  double dilation_angle() const { return dilation_angle_; }
  double cohesion() const { return cohesion_; }

 private:
  double lambda_, mu_, friction_angle_, dilation_angle_, cohesion_;
  double k_, m_, strength_;  // functions of the angles and c, see PrincipalMohrCoulomb
};

template <int dim>
using MaterialLaw =
    std::variant<LinearElastic<dim>, NeoHookean<dim>, HenckyElastic<dim>, MohrCoulomb<dim>>;

template <int dim>
struct Material {
  std::string law_name;
  double density = 0;  ///< [kg/m^3] > 0, in the stress-free state
  MaterialLaw<dim> law;
};

/// Stress update of whichever law it is; loops over many points dispatch once and call the law.
template <int dim>
bool update(const MaterialLaw<dim>& law, const Matrix<dim>& H, const MaterialState<dim>& state_n,
            StressUpdate<dim>& out, Tangent<dim>* A) {
  return std::visit([&](const auto& model) { return model.update(H, state_n, out, A); }, law);
}

/// Read {"law": "linear_elastic" | "neo_hookean" | "hencky_elastic" | "mohr_coulomb",
/// "density", "young_modulus", "poisson_ratio" and for mohr_coulomb "friction_angle" [deg],
/// "dilation_angle" [deg], "cohesion" [Pa]}.
template <int dim>
Material<dim> read_material(ConfigReader in);

}  // namespace gabion
