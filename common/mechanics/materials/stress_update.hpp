// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <concepts>
#include <span>
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

/// Two numbers that a law remembers of a point besides MaterialState. What they are is the law's:
/// see RemembersInternal.
using InternalState = Eigen::Vector2d;

/// Why a law gives no stress: the step has to be shorter.
enum class Refusal {
  squeezed,     ///< det(1 + H) <= 0
  unsolved,     ///< an equation of the law has no solution that was found
  pores_closed  ///< the pores of saturated soil would be
};

/// Part of the law that holds a point at the end of a step.
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
  InternalState internal;               ///< set by laws that remember it
  Refusal refusal = Refusal::squeezed;  ///< where there is no stress

  bool plastic() const { return region != YieldRegion::elastic; }
};

/// Data of the step and of the point that a law may use besides the strain.
struct PointContext {
  double dt = 0;  ///< step, or substep, in which the strain comes about [s]
  /// Width of the narrowest band of shear that the grid can make at the point [m]; 0: no grid.
  double band_width = 0;
  InternalState internal = InternalState::Zero();  ///< at the start, of laws that remember it
  /// State variables of a law from a library (Umat) at the start, as many as it has; empty: virgin.
  std::span<const double> variables{};
  std::span<double> new_variables{};  ///< room for those at the end; empty: not wanted
};

/// Laws whose stress depends on the context, besides `update` without one.
template <class Law, int dim>
concept ContextualLaw = requires(const Law& law, StressUpdate<dim>& out, Tangent<dim>* A) {
  law.update(PointContext{}, Matrix<dim>{}, MaterialState<dim>{}, out, A);
};

/// Laws with internal variables: all zero in the virgin soil, or as its initial stress sets them;
/// changed only where a point yields.
/// `internal_names` are those of the fields in which frames have them.
template <class Law>
concept RemembersInternal = requires {
  { Law::internal_names[0] } -> std::convertible_to<const char*>;
  { Law::internal_names[1] } -> std::convertible_to<const char*>;
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
