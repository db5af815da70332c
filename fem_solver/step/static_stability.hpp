// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "fem_solver/step/equilibrium.hpp"

namespace gabion::fem {

/// Looks for states of rest that the structure would leave, because its stiffness is negative in
/// some direction. It works on one rank, not where cracks soften, nor beside lines that may be
/// slack, which leave nodes without any stiffness, nor where the stiffness never changes, nor where
/// the structure is so large that its systems are solved without factors.
template <int dim>
class StaticStability {
 public:
  explicit StaticStability(const FemSettings<dim>& settings);

  /// Warn of the first such state, and count them. @note Costs a factorisation.
  void look_at(const StructureState& state_n, const StructureState& state,
               Equilibrium<dim>& equilibrium);
  std::int64_t unstable_states() const { return unstable_states_; }

 private:
  bool on_;
  bool beams_;
  std::int64_t unstable_states_ = 0;
};

}  // namespace gabion::fem
