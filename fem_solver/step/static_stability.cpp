// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/step/static_stability.hpp"

#include <algorithm>
#include <limits>

#include "common/base/log.hpp"
#include "common/mechanics/petsc/eigenvalue_signs.hpp"
#include "common/mechanics/petsc/linear_method.hpp"
#include "fem_solver/step/full_steps.hpp"
#include "fem_solver/step/kept_factor.hpp"

namespace gabion::fem {

namespace {

// Whether statics of this structure are solved by factors, so that another factor costs no more
// than they do.
template <int dim>
bool is_factored(const FemSettings<dim>& settings) {
  const LinearRegime statics{.symmetric = settings.line_materials.empty(),
                             .courant = std::numeric_limits<double>::infinity(),
                             .slender = is_slender(settings.mesh, settings.ranks)};
  const std::int64_t num_dofs = std::int64_t{dim} * settings.mesh.num_nodes_total();
  return choose_linear_method(full_step_solver(settings), statics, dim, num_dofs, 1).direct();
}

template <int dim>
bool shows_instability(const FemSettings<dim>& settings) {
  const bool only_beams = std::ranges::all_of(settings.line_materials, [](const auto& line) {
    return line.beam.has_value() || line.embedded;
  });
  const bool cracks = std::ranges::any_of(
      settings.materials, [](const auto& material) { return material.law_name == "concrete"; });
  const bool is_linear = settings.line_materials.empty() &&
                         std::ranges::all_of(settings.materials, [](const auto& material) {
                           return material.law_name == "linear_elastic";
                         });
  return settings.ranks.alone() && settings.membranes.empty() && only_beams && !cracks &&
         !is_linear && is_factored(settings);
}

}  // namespace

template <int dim>
StaticStability<dim>::StaticStability(const FemSettings<dim>& settings)
    : on_(shows_instability(settings)), beams_(settings.beam_nodes().any()) {}

template <int dim>
void StaticStability<dim>::look_at(const StructureState& state_n, const StructureState& state,
                                   Equilibrium<dim>& equilibrium) {
  if (!on_) return;
  // The derivative by the rotations of a step is symmetric where they are zero: at the start of the
  // next step.
  equilibrium.set_history(beams_ ? state.history : state_n.history);
  BlockMatrix<dim> K;
  equilibrium.set_pattern(K);
  equilibrium.assemble_tangent(state.motion.u, 1, /*with_inertia=*/false, K);
  const std::int64_t directions = count_negative_eigenvalues(K);
  if (directions == 0 || unstable_states_++ > 0) return;
  log::warn(
      "t = {:.6g} s: the equilibrium that was found is not stable: the stiffness is negative in {} "
      "direction(s), so the structure has buckled or snapped through and would leave this state. A "
      "dynamic analysis from the reference configuration shows where it goes; summary.json counts "
      "such states (unstable_equilibria)",
      state.time, directions);
}

template class StaticStability<2>;
template class StaticStability<3>;

}  // namespace gabion::fem
