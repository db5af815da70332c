// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/step/step_work.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/base/log.hpp"

namespace gabion::fem {

template <int dim>
double work_of_loads(const Equilibrium<dim>& equilibrium, const BoundaryConditions<dim>& conditions,
                     const StructureState& state_n, const StructureState& trial,
                     std::span<const double> du) {
  const SharedNodes& shared = equilibrium.shared();
  const auto constrained = conditions.constrained_dofs();
  auto next = constrained.begin();
  double sum = 0;
  for (std::size_t i = 0; i < du.size(); ++i) {
    if (next != constrained.end() && static_cast<std::size_t>(*next) == i) {
      ++next;
      continue;
    }
    if (!shared.owns(static_cast<std::int32_t>(i / dim))) continue;
    sum += du[i] * (0.5 * (state_n.f_ext[i] + trial.f_ext[i]) + trial.f_step[i]);
  }
  return shared.total(sum);
}

template <int dim>
double work_of_supports(const Equilibrium<dim>& equilibrium,
                        const BoundaryConditions<dim>& conditions, const StructureState& state_n,
                        const StructureState& trial, bool dynamic) {
  const SharedNodes& shared = equilibrium.shared();
  const StructureMotion &start = state_n.motion, &end = trial.motion;
  const auto constrained = conditions.constrained_dofs();
  const auto rests = [&](auto dof) {
    return end.u[dof] == start.u[dof] && end.v[dof] == start.v[dof];
  };
  if (shared.all(std::ranges::all_of(constrained, rests))) return 0;
  std::vector<double> momentum(end.v.size(), 0.0);  // its change
  if (dynamic) {
    for (std::size_t i = 0; i < momentum.size(); ++i) momentum[i] = end.v[i] - start.v[i];
    momentum = equilibrium.mass_times(momentum);
  }
  double sum = 0;
  for (const auto dof : constrained) {
    if (!shared.owns(dof / dim)) continue;
    sum += 0.5 * (end.u[dof] - start.u[dof]) * (state_n.f_int[dof] + trial.f_int[dof]) +
           0.5 * (start.v[dof] + end.v[dof]) * momentum[dof];
  }
  return shared.total(sum);
}

template <int dim>
double work_before_start(const Equilibrium<dim>& equilibrium,
                         const BoundaryConditions<dim>& conditions, const StructureState& state) {
  double largest = 0;
  for (const double u : conditions.displacements(0)) largest = std::max(largest, std::abs(u));
  largest = equilibrium.shared().largest(largest);
  if (largest == 0) return 0;
  log::warn(
      "prescribed displacements are up to {:.3g} m at time 0, where all other nodes are at zero: "
      "the structure starts with {:.3g} J of elastic energy, counted as external work; to avoid "
      "it: tables that begin at 0, or \"initial_equilibrium\"",
      largest, state.elastic_energy);
  return state.elastic_energy;
}

template double work_of_loads<2>(const Equilibrium<2>&, const BoundaryConditions<2>&,
                                 const StructureState&, const StructureState&,
                                 std::span<const double>);
template double work_of_loads<3>(const Equilibrium<3>&, const BoundaryConditions<3>&,
                                 const StructureState&, const StructureState&,
                                 std::span<const double>);
template double work_of_supports<2>(const Equilibrium<2>&, const BoundaryConditions<2>&,
                                    const StructureState&, const StructureState&, bool);
template double work_of_supports<3>(const Equilibrium<3>&, const BoundaryConditions<3>&,
                                    const StructureState&, const StructureState&, bool);

template double work_before_start<2>(const Equilibrium<2>&, const BoundaryConditions<2>&,
                                     const StructureState&);
template double work_before_start<3>(const Equilibrium<3>&, const BoundaryConditions<3>&,
                                     const StructureState&);

}  // namespace gabion::fem
