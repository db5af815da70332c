// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/fem_solver.hpp"

#include <fmt/format.h>

#include <cmath>

#include "common/base/require.hpp"

namespace gabion::fem {

template <int dim>
FemSolver<dim>::FemSolver(FemSettings<dim> settings, MPI_Comm comm,
                          const std::string& output_folder)
    : settings_(std::move(settings)),
      boundary_(settings_),
      probes_(settings_),
      step_(settings_, comm),
      state_(step_.initial_state()) {
  if (!output_folder.empty()) output_.emplace(settings_.mesh, output_folder, comm);
}

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
  FemState trial;
  StepReport report = step_.solve(state_, boundary_.nodal_forces(received), request.dt, trial);
  sent = boundary_.displacements(trial.motion.u);
  trial_ = std::move(trial);
  return report;
}

template <int dim>
AcceptReport FemSolver<dim>::accept_step(const StepRequest& request, bool solved) {
  if (solved) {
    require(trial_.has_value(), "step {}: accepted without a solution", request.step);
    state_ = std::move(*trial_);
  }
  state_.time = request.time + request.dt;
  trial_.reset();
  step_.forget_iterates();
  return {probes(), step_.at_rest(state_), 0};
}

template <int dim>
void FemSolver<dim>::reject_step() {
  trial_.reset();
  step_.forget_iterates();
}

template <int dim>
void FemSolver<dim>::write_output(double time) {
  if (output_) output_->write(time, state_, step_.equilibrium());
}

template <int dim>
std::vector<double> FemSolver<dim>::probes() const {
  return probes_.values(state_, step_.equilibrium());
}

template <int dim>
Json FemSolver<dim>::summary() const {
  Json result = step_.summary();
  result["nodes"] = settings_.mesh.nodes.size();
  result["unknowns"] =
      settings_.mesh.nodes.size() * dim - step_.conditions().constrained_dofs().size();
  result["frame_bytes"] = FemOutput<dim>::frame_bytes(settings_.mesh);
  result["cells"] = settings_.mesh.num_cells();
  result["cell_type"] = name(settings_.mesh.cell_type);
  result["material"] = settings_.material.law_name;
  result["analysis"] = settings_.dynamic ? "dynamic" : "static";
  return result;
}

template class FemSolver<2>;
template class FemSolver<3>;

namespace {

template <int dim>
std::unique_ptr<Solver> make_solver(const Scene& scene, ConfigReader& in, MPI_Comm comm,
                                    const std::string& output_folder, AloneSettings* alone) {
  auto settings = read_fem_settings<dim>(scene, in);
  if (alone) *alone = read_alone_settings(in);
  in.finish();
  return std::make_unique<FemSolver<dim>>(std::move(settings), comm, output_folder);
}

}  // namespace

std::unique_ptr<Solver> make_fem_solver(const Scene& scene, ConfigReader& in, MPI_Comm comm,
                                        const std::string& output_folder, AloneSettings* alone) {
  return read_dimension(in) == 2 ? make_solver<2>(scene, in, comm, output_folder, alone)
                                 : make_solver<3>(scene, in, comm, output_folder, alone);
}

}  // namespace gabion::fem
