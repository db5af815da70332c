// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <type_traits>

#include "common/mechanics/materials/plane_return.hpp"
#include "common/mechanics/materials/principal_surface.hpp"
#include "common/mechanics/materials/space_return.hpp"
#include "common/mechanics/materials/stress_update.hpp"

namespace gabion {

struct MohrCoulombParameters {
  double lambda = 0;          ///< [Pa]
  double mu = 0;              ///< [Pa]
  double friction_angle = 0;  ///< phi [rad], 0 < phi < pi/2
  double dilation_angle = 0;  ///< psi [rad], 0 <= psi <= phi
  double cohesion = 0;        ///< c [Pa], >= 0
  ApexVolume apex_volume = ApexVolume::gap;
  /// Limit of the principal stresses [Pa], 0 <= tension_cutoff < c cot phi, or no_cutoff.
  double tension_cutoff = no_cutoff;
};

/// Hencky elasticity with non-associated Mohr-Coulomb plasticity in principal Kirchhoff stresses,
/// tension positive: f = k t1 - t3 - 2 c sqrt(k), k = (1 + sin phi) / (1 - sin phi),
/// and with t1 <= tension_cutoff, along whose gradients it flows (Rankine).
template <int dim>
class MohrCoulomb {
 public:
  using BatchReturn = std::conditional_t<dim == 2, PlaneReturn, SpaceReturn>;
  static constexpr bool is_elastic = false;
  explicit MohrCoulomb(const MohrCoulombParameters& parameters);
  MohrCoulomb(double lambda, double mu, double friction_angle, double dilation_angle,
              double cohesion)
      : MohrCoulomb(MohrCoulombParameters{.lambda = lambda,
                                          .mu = mu,
                                          .friction_angle = friction_angle,
                                          .dilation_angle = dilation_angle,
                                          .cohesion = cohesion}) {}

  bool update(const Matrix<dim>& H, const MaterialState<dim>& state_n, StressUpdate<dim>& out,
              Tangent<dim>* A) const;
  /// Return of four points at once; null with a tension cut-off.
  const BatchReturn* batch_return() const { return batch_return_ ? &*batch_return_ : nullptr; }
  bool symmetric_tangent() const {
    return parameters_.dilation_angle == parameters_.friction_angle;
  }
  double p_wave_modulus() const { return parameters_.lambda + 2 * parameters_.mu; }
  double shear_modulus() const { return parameters_.mu; }

  const MohrCoulombParameters& parameters() const { return parameters_; }
  const PrincipalMohrCoulomb& principal() const { return principal_; }

 private:
  MohrCoulombParameters parameters_;
  PrincipalMohrCoulomb principal_;
  std::optional<BatchReturn> batch_return_;
};

}  // namespace gabion
