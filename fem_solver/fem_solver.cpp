// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/fem_solver.hpp"

#include <cmath>

#include "common/base/require.hpp"

namespace gabion::fem {

template <int dim>
FemSolver<dim>::FemSolver(MPI_Comm comm, FemSettings<dim> settings,
                          const std::string& output_folder)
    : settings_(std::move(settings)),
      wet_surfaces_(settings_.mesh, settings_.interfaces),
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
  State state;
  StateWriter writer(state);
  state_.visit_state(writer);
  return state;
}

template <int dim>
void FemSolver<dim>::load_state(const State& state) {
  reject_step();
  StateReader reader(state);
  state_.visit_state(reader);
}

template class FemSolver<2>;
template class FemSolver<3>;

}  // namespace gabion::fem
