// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <type_traits>

#include "common/mechanics/materials/plane_return.hpp"
#include "common/mechanics/materials/principal_surface.hpp"
#include "common/mechanics/materials/space_return.hpp"
#include "common/mechanics/materials/stress_update.hpp"

namespace gabion {

struct TrescaParameters {
  double lambda = 0;    ///< [Pa]
  double mu = 0;        ///< [Pa]
  double cohesion = 0;  ///< undrained shear strength c [Pa], > 0
  /// Limit of the principal stresses [Pa], >= 0, or no_cutoff.
  double tension_cutoff = no_cutoff;
  ApexVolume apex_volume = ApexVolume::gap;  ///< of the isotropic corner of the cut-off
};

/// Hencky elasticity with associated Tresca plasticity in principal Kirchhoff stresses:
/// f = t1 - t3 - 2 c, and with t1 <= tension_cutoff (Rankine). Without cut-off, plastic flow is
/// isochoric and there is no apex.
template <int dim>
class Tresca {
 public:
  using BatchReturn = std::conditional_t<dim == 2, PlaneReturn, SpaceReturn>;
  static constexpr bool is_elastic = false;
  explicit Tresca(const TrescaParameters& parameters)
      : parameters_(parameters),
        principal_{.lambda = parameters.lambda,
                   .mu = parameters.mu,
                   .k = 1,
                   .m = 1,
                   .strength = 2 * parameters.cohesion} {
    if (parameters.tension_cutoff == no_cutoff) {
      batch_return_.emplace(principal_, parameters.apex_volume == ApexVolume::gap);
    }
  }

  bool update(const Matrix<dim>& H, const MaterialState<dim>& state_n, StressUpdate<dim>& out,
              Tangent<dim>* A) const;
  /// Return of four points at once; null with a tension cut-off.
  const BatchReturn* batch_return() const { return batch_return_ ? &*batch_return_ : nullptr; }
  bool symmetric_tangent() const { return true; }
  double p_wave_modulus() const { return parameters_.lambda + 2 * parameters_.mu; }
  double shear_modulus() const { return parameters_.mu; }

  const TrescaParameters& parameters() const { return parameters_; }
  const PrincipalMohrCoulomb& principal() const { return principal_; }

 private:
  TrescaParameters parameters_;
  PrincipalMohrCoulomb principal_;
  std::optional<BatchReturn> batch_return_;
};

}  // namespace gabion
