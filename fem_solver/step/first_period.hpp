// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "fem_solver/step/structure_step.hpp"

namespace gabion::fem {

/// Period of the slowest vibration of a structure about a state [s], by twelve vectors of Lanczos'
/// method on (K + c M)^-1 M with the c of a step of dt, in the inner product of M. It is never
/// longer than that of the discrete structure, and close to it where dt is not below a hundredth of
/// it. Infinite where the structure moves without a stiffness.
/// @throws ConvergenceError  K + c M cannot be factored
/// @note Costs a factor of K + c M. @pre one rank
template <int dim>
double first_period(const StructureStep<dim>& step, const StructureState& state, double dt);

/// Warns of steps that are long against the first vibration of the structure, where nothing damps
/// what they excite: the trapezoidal rule without damping, dynamic analysis. It works on one rank,
/// and not where the structure is so large that a factor would take long.
template <int dim>
class FirstPeriodCheck {
 public:
  explicit FirstPeriodCheck(const FemSettings<dim>& settings);

  /// Look at the first step, of dt, that ended in this state.
  void look_at(const StructureStep<dim>& step, const StructureState& state, double dt);

 private:
  bool due_;
};

}  // namespace gabion::fem
