// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/fem_solver.hpp"

#include <cmath>
#include <variant>

#include "common/base/require.hpp"
#include "common/mechanics/petsc/numbered_values.hpp"
#include "common/mechanics/ranks/text.hpp"

namespace gabion::fem {

template <int dim>
FemSolver<dim>::FemSolver(MPI_Comm comm, FemSettings<dim> settings,
                          const std::string& output_folder)
    : settings_(std::move(settings)),
      wet_surfaces_(settings_.mesh, settings_.interfaces, settings_.ranks),
      step_(settings_, comm),
      report_(settings_, step_, output_folder),
      state_(step_.initial_state()) {}

template <int dim>
void FemSolver<dim>::set_motion(std::vector<double> u, std::vector<double> v) {
  require(u.size() == settings_.mesh.nodes.size() * dim && v.size() == u.size(),
          "initial motion: found {} and {} values, expected {} nodes x {}", u.size(), v.size(),
          settings_.mesh.nodes.size(), dim);
  step_.forget_iterates();
  trial_.reset();
  state_ = step_.state_of(std::move(u), std::move(v));
}

template <int dim>
StepReport FemSolver<dim>::solve_step(const StepRequest& request, const InterfaceValues& received,
                                      InterfaceValues& sent) {
  require(request.dt > 0, "step {}: found dt {}, allowed: dt > 0", request.step, request.dt);
  require(std::abs(request.time - state_.time) <= 1e-6 * request.dt,
          "step {}: asked to start at {} s, but the accepted state is that of {} s", request.step,
          request.time, state_.time);
  trial_.reset();
  state_.time = request.time;
  StructureState trial;
  StepReport report = step_.solve(state_, wet_surfaces_.nodal_forces(received), request.dt, trial);
  sent = wet_surfaces_.displacements(trial.motion.u);
  trial_ = std::move(trial);
  return report;
}

template <int dim>
AcceptReport FemSolver<dim>::accept_step(const StepRequest& request, bool solved) {
  if (solved) {
    require(trial_.has_value(), "step {}: accepted without a solution", request.step);
    step_.complete(state_, request.dt, *trial_);
    state_ = std::move(*trial_);
    const Equilibrium<dim>& equilibrium = step_.equilibrium();
    if (std::holds_alternative<LinearElastic<dim>>(settings_.material.law)) {
      const double angle = equilibrium.cells().largest_rotation(state_.motion.u);
      rotation_.look(equilibrium.shared().largest(angle), "structure");
    }
  }
  state_.time = request.time + request.dt;
  trial_.reset();
  step_.forget_iterates();
  return {.probes = probes(), .at_rest = step_.at_rest(state_)};
}

template <int dim>
void FemSolver<dim>::reject_step() {
  trial_.reset();
  step_.forget_iterates();
}

template <int dim>
State FemSolver<dim>::save_state() {
  const MeshRanks& ranks = settings_.ranks;
  StructureState own = state_;
  for (const auto& [name, values] : own.nodal_vectors()) {
    *values = ranks.owned(std::move(*values), dim);
  }
  auto nodes = ranks.owned_nodes(settings_.mesh.num_nodes_total());
  State state;
  StateWriter writer(state);
  own.visit_state(writer, nodes);
  return state;
}

template <int dim>
void FemSolver<dim>::load_state(const State& state) {
  join_states(state, {&state, 1});
}

template <int dim>
void FemSolver<dim>::join_states(const State& first, std::span<const State> own) {
  reject_step();
  const Mesh<dim>& mesh = settings_.mesh;
  const MeshRanks& ranks = settings_.ranks;
  StructureState loaded;
  std::vector<std::int64_t> nodes;
  together(ranks.comm(), [&] {
    StateJoiner joiner(first, own);
    loaded.visit_state(joiner, nodes);
    for (const auto& [name, values] : loaded.nodal_vectors()) {
      require(values->size() == nodes.size() * dim,
              "saved state: \"{}\" has {} values for {} nodes, allowed: {} a node", name,
              values->size(), nodes.size(), dim);
    }
  });
  const NumberedValues holders(ranks.alone() ? MPI_COMM_SELF : ranks.comm(), nodes,
                               ranks.held_nodes(mesh), ranks.num_nodes_of_all(mesh),
                               "saved state: nodes");
  for (const auto& [name, values] : loaded.nodal_vectors()) *values = holders.send(*values, dim);
  state_ = std::move(loaded);
}

template class FemSolver<2>;
template class FemSolver<3>;

}  // namespace gabion::fem
