// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/mechanics/materials/apex_volume.hpp"
#include "common/mechanics/materials/drucker_prager_return.hpp"

namespace gabion {

/// State of stress in which the cone has the strength of Mohr-Coulomb with the same angles and
/// cohesion.
enum class ConeMatch {
  plane_strain,  ///< flowing in plane strain, for every psi: the match of Davis (1968)
  compression,   ///< the edges of triaxial compression, outer cone
  extension      ///< the edges of triaxial extension
};

struct DruckerPragerParameters {
  double lambda = 0;          ///< [Pa]
  double mu = 0;              ///< [Pa]
  double friction_angle = 0;  ///< phi [rad], 0 < phi < pi/2
  double dilation_angle = 0;  ///< psi [rad], 0 <= psi <= phi
  double cohesion = 0;        ///< c [Pa], >= 0
  ConeMatch match = ConeMatch::plane_strain;
  ApexVolume apex_volume = ApexVolume::gap;
};

/// Cone of the given match.
///
/// Plane strain: with no plastic strain out of the plane, the flow rule puts the out-of-plane
/// stress at the in-plane mean minus eta_bar sqrt(J2), and sqrt(J2) = R / w with R the radius of
/// the in-plane circle and w^2 = 1 - eta_bar^2 / 3. That makes the yield condition R
/// sin(phi)-linear in the in-plane mean and the dilation sin(psi) of the shear if
///
///     eta_bar = sin psi / sqrt(1 + sin^2 psi / 3)
///     eta = sin phi sqrt(1 + sin^2 psi / 3) / (1 + sin phi sin psi / 3) ,   strength = eta c cot
///     phi
///
/// Compression and extension: eta = 6 sin phi / (sqrt(3) (3 -+ sin phi)), eta_bar that expression
/// of psi.
PrincipalDruckerPrager cone_constants(const DruckerPragerParameters& parameters);

/// Hencky elasticity with a non-associated Drucker-Prager cone in Kirchhoff stresses.
template <int dim>
class DruckerPrager {
 public:
  static constexpr bool is_elastic = false;
  explicit DruckerPrager(const DruckerPragerParameters& parameters)
      : parameters_(parameters), cone_(cone_constants(parameters)) {}

  bool update(const Matrix<dim>& H, const MaterialState<dim>& state_n, StressUpdate<dim>& out,
              Tangent<dim>* A) const;
  bool symmetric_tangent() const {
    return parameters_.dilation_angle == parameters_.friction_angle;
  }
  double p_wave_modulus() const { return parameters_.lambda + 2 * parameters_.mu; }
  double shear_modulus() const { return parameters_.mu; }

  const DruckerPragerParameters& parameters() const { return parameters_; }
  const PrincipalDruckerPrager& cone() const { return cone_; }

 private:
  DruckerPragerParameters parameters_;
  PrincipalDruckerPrager cone_;
};

}  // namespace gabion
