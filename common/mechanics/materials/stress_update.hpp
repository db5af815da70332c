// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

#include "common/mechanics/tensor.hpp"

namespace gabion {

/// History of one material point. Finite-strain laws keep e = b_e - 1 (b_e elastic left
/// Cauchy-Green tensor), which resolves strains far below 1e-8; the small-strain law keeps the
/// accumulated strain in `e`.
template <int dim>
struct MaterialState {
  Symmetric<dim> e = Symmetric<dim>::Zero();
  /// Accumulated norm of the plastic Hencky strain increments, without the volume in `gap`.
  double plastic_strain = 0;
  /// Volumetric Hencky strain opened at the apex and not yet closed, >= 0 to rounding; stays 0
  /// for laws that do not keep it.
  double gap = 0;
};

/// What holds a point at the end of a step.
enum class YieldRegion {
  elastic,
  shear,              ///< friction and cohesion: planes and edges, or the cone
  tension,            ///< one or two principal stresses at the tension cut-off
  shear_and_tension,  ///< both at once
  apex                ///< the isotropic tension that the material can bear
};

/// Word for tables and log lines, such as "shear and tension".
constexpr std::string_view region_name(YieldRegion region) {
  switch (region) {
    case YieldRegion::shear:
      return "shear";
    case YieldRegion::tension:
      return "tension";
    case YieldRegion::shear_and_tension:
      return "shear and tension";
    case YieldRegion::apex:
      return "apex";
    default:
      return "elastic";
  }
}

/// Result of one stress update.
template <int dim>
struct StressUpdate {
  /// First Piola-Kirchhoff stress with respect to the configuration of `state_n`, per unit of the
  /// volume in which the material is free of stress: P = tau (1 + H)^-T  [Pa].
  Matrix<dim> P;
  Symmetric<dim> tau;  ///< Kirchhoff stress [Pa]
  MaterialState<dim> state;
  double J = 1;       ///< det(1 + H), volume ratio of this step
  double energy = 0;  ///< elastic energy per unit of stress-free volume [J/m^3]
  /// Hencky strain of the step that is not elastic, a gap's closing included.
  Symmetric<dim> plastic_increment = Symmetric<dim>::Zero();
  YieldRegion region = YieldRegion::elastic;

  bool plastic() const { return region != YieldRegion::elastic; }
};

/// What a law may know of the step besides the strain.
struct PointContext {
  double dt = 0;  ///< step, or substep, in which the strain comes about [s]
};

/// Laws whose stress depends on the context, besides `update` without one.
template <class Law, int dim>
concept ContextualLaw = requires(const Law& law, StressUpdate<dim>& out, Tangent<dim>* A) {
  law.update(PointContext{}, Matrix<dim>{}, MaterialState<dim>{}, out, A);
};

/// A law in a step: its stress update takes the context if the law has a use for it.
template <class Law, int dim>
struct LawInStep {
  const Law& law;
  PointContext context;

  bool update(const Matrix<dim>& H, const MaterialState<dim>& state_n, StressUpdate<dim>& out,
              Tangent<dim>* A) const {
    if constexpr (ContextualLaw<Law, dim>) {
      return law.update(context, H, state_n, out, A);
    } else {
      return law.update(H, state_n, out, A);
    }
  }
};

}  // namespace gabion
