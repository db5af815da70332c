// SPDX-License-Identifier: BSD-3-Clause
// Treatment of cells that fail in a step.
#include <fmt/format.h>

#include <memory>
#include <utility>

#include "common/base/unbalanced.hpp"
#include "fem_solver/step/structure_step.hpp"

namespace gabion::fem {

template <int dim>
std::vector<Failure> StructureStep<dim>::fail_cells(double dt, StructureState& state) {
  if (!equilibrium_.may_fail()) return {};
  FailureChange change = failure_after(equilibrium_.cells(), {.u = state.motion.u,
                                                              .history = *state.history,
                                                              .time = state.time,
                                                              .dt = dt,
                                                              .dynamic = dynamic_});
  if (shared().all(change.history.empty())) return {};
  const auto before = equilibrium_.internal_forces(state.motion.u, state.history);
  if (!change.history.empty()) {
    state.history = std::make_shared<const std::vector<double>>(std::move(change.history));
  }
  const auto after = equilibrium_.internal_forces(state.motion.u, state.history);
  std::vector<double> released = before.f;
  for (std::size_t i = 0; i < released.size(); ++i) released[i] -= after.f[i];
  for (std::size_t i = 0; i < released.size(); ++i) state.f_int[i] -= released[i];
  state.failed_energy += before.energy - after.energy;
  state.elastic_energy -= before.energy - after.energy;
  if (dynamic_) {
    const std::vector<double> a = equilibrium_.acceleration_of(released);
    for (std::size_t i = 0; i < a.size(); ++i) state.motion.a[i] += a[i];
    equilibrium_.embedded().follow(state.motion.a);
  } else {
    state.balanced = false;
  }
  state.tangent.reset();
  return std::move(change.begun);
}

/// @throws ConvergenceError  that says how many cells failed, where some did
template <int dim>
void StructureStep<dim>::explain_failure(const StructureState& state_n,
                                         const ConvergenceError& error) const {
  if (dynamic_ || !equilibrium_.may_fail()) return;
  const auto own = static_cast<double>(count_failed(equilibrium_.cells(), *state_n.history));
  const double failed = shared().total(own);
  if (failed == 0) return;
  throw_as(fmt::format("{}; {} cells or lines failed, and a loaded part that nothing holds has no "
                       "static equilibrium: \"analysis\" \"dynamic\" shows where it goes",
                       error.what(), failed),
           error);
}

template std::vector<Failure> StructureStep<2>::fail_cells(double, StructureState&);
template std::vector<Failure> StructureStep<3>::fail_cells(double, StructureState&);
template void StructureStep<2>::explain_failure(const StructureState&,
                                                const ConvergenceError&) const;
template void StructureStep<3>::explain_failure(const StructureState&,
                                                const ConvergenceError&) const;

}  // namespace gabion::fem
