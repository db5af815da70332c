// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <limits>
#include <type_traits>

#include "common/mechanics/materials/plane_return.hpp"
#include "common/mechanics/materials/softening_return.hpp"
#include "common/mechanics/materials/space_return.hpp"
#include "common/mechanics/materials/stress_update.hpp"

namespace gabion {

struct SofteningParameters {
  double lambda = 0;  ///< [Pa]
  double mu = 0;      ///< [Pa]
  StrengthCurve curve = {};
  bool frictional = true;      ///< Mohr-Coulomb; false: Tresca, all angles of the curve 0
  bool by_slip = true;         ///< the curve's shear is the slip [m]; false: kappa
  double friction_angle = 0;   ///< of the virgin soil [rad]
  double relaxation_time = 0;  ///< t_v of Duvaut and Lions [s], >= 0; 0 with a rate gain
  RateGain rate_gain = {};     ///< Tresca alone
  ApexVolume apex_volume =
      ApexVolume::gap;                ///< forget where there is a relaxation time and an apex
  double tension_cutoff = no_cutoff;  ///< of the virgin soil [Pa], scaled with the cohesion
};

/// Mohr-Coulomb or Tresca (MohrCoulomb, Tresca) whose cohesion and angles follow a curve of the
/// shear that the point has seen. Shear is measured by the deviatoric plastic strain,
///
///     d kappa = sqrt(2/3) |dev d eps_p| ,   d slip = sqrt(3) w d kappa
///
/// with w = PointContext::band_width: all slip of a surface takes place in one band of the grid, so
/// that a curve of the slip has the same dissipation on every grid. With a relaxation time the
/// stress lags behind (Duvaut and Lions), by r = dt / t_v: tau = (tau_trial + r tau_inf) / (1 + r).
template <int dim>
class SofteningSoil {
 public:
  static constexpr bool is_elastic = false;
  /// InternalState: kappa and the slip [m].
  static constexpr std::array internal_names = {"softening_strain", "slip"};
  explicit SofteningSoil(const SofteningParameters& parameters);

  bool update(const PointContext& context, const Matrix<dim>& H, const MaterialState<dim>& state_n,
              StressUpdate<dim>& out, Tangent<dim>* A) const;
  /// The response of virgin soil after infinite time, without the regularisation by the grid.
  bool update(const Matrix<dim>& H, const MaterialState<dim>& state_n, StressUpdate<dim>& out,
              Tangent<dim>* A) const {
    const double for_ever = std::numeric_limits<double>::infinity();
    return update({.dt = for_ever}, H, state_n, out, A);
  }
  /// Update those of four points that stay elastic; none with a tension cut-off.
  /// @returns which they are
  LaneMask update_elastic(const std::array<PointContext, num_lanes>& contexts,
                          PointBatch<dim>& batch, bool with_A) const;
  bool symmetric_tangent() const { return false; }
  double p_wave_modulus() const { return parameters_.lambda + 2 * parameters_.mu; }
  double shear_modulus() const { return parameters_.mu; }

  const SofteningParameters& parameters() const { return parameters_; }
  const SofteningSurface& surface() const { return surface_; }
  /// The law of the virgin soil.
  const PrincipalMohrCoulomb& principal() const { return virgin_.law; }

 private:
  using BatchReturn = std::conditional_t<dim == 2, PlaneReturn, SpaceReturn>;
  ShearSoFar shear_of(const PointContext& context) const;

  SofteningParameters parameters_;
  SofteningSurface surface_;
  SoftenedConstants virgin_;
  BatchReturn batch_;
};

}  // namespace gabion
