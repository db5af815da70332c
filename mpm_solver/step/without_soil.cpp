// SPDX-License-Identifier: BSD-3-Clause
// Steps after all soil has left the background grid: surfaces move, nothing acts on them.
#include <algorithm>

#include "mpm_solver/step/soil_step.hpp"

namespace gabion::mpm {

template <int dim>
StepReport SoilStep<dim>::solve_without_soil(const StepRequest& request,
                                             const InterfaceValues& received) {
  if (dt_ != request.dt) {
    sizes_.begin(request);
    enter_phase(request.time);
    require_within(phase(), request.time, request.dt);
    dt_ = request.dt;
    equilibrium_.reset();
    du_.clear();
  }
  state_.surfaces.receive(received);
  state_.surfaces.move_walls(request.time + request.dt);
  StepReport report;
  state_.surfaces.report(report);
  return report;
}

template <int dim>
AcceptReport SoilStep<dim>::accept_without_soil(const StepRequest& request) {
  const double time = request.time + request.dt;
  const auto& phases = model_.settings.phases;
  std::fill(state_.wall_forces.begin(), state_.wall_forces.end(), Vector<dim>::Zero());
  state_.rigid_wall_forces = state_.surfaces.forces_on_walls();
  StepMeasures measures;
  measures.dt = dt_;
  sizes_.accept(measures, largest_step(phases[phase_at(phases, time)], time));
  state_.gauges.add_step({}, state_.points, dt_);
  state_.surfaces.accept();
  state_.ledger.set_contact_energy(state_.surfaces.energy());
  state_.nearly_linear = false;
  state_.contact_rate = 0;
  dt_ = 0;
  AcceptReport report;
  report.details = {{"active_nodes", 0},
                    {"points_changed_cell", 0},
                    {"dt_limit", static_cast<int>(sizes_.proposal().limit)}};
  report.proposed_dt = sizes_.proposal().dt;
  return report;
}

template StepReport SoilStep<2>::solve_without_soil(const StepRequest&, const InterfaceValues&);
template StepReport SoilStep<3>::solve_without_soil(const StepRequest&, const InterfaceValues&);
template AcceptReport SoilStep<2>::accept_without_soil(const StepRequest&);
template AcceptReport SoilStep<3>::accept_without_soil(const StepRequest&);

}  // namespace gabion::mpm
