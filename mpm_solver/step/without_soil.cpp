// SPDX-License-Identifier: BSD-3-Clause
// Steps after all soil has left the background grid: surfaces move, nothing acts on them.
#include <algorithm>

#include "mpm_solver/step/soil_step.hpp"

namespace gabion::mpm {

template <int dim>
AcceptReport SoilStep<dim>::accept_without_soil(double time) {
  std::fill(state_.wall_forces.begin(), state_.wall_forces.end(), Vector<dim>::Zero());
  state_.rigid_wall_forces = state_.surfaces.forces_on_walls();
  StepMeasures measures;
  measures.dt = start_.dt;
  sizes_.accept(measures, largest_step_from(time));
  state_.gauges.add_step({}, state_.points, start_.dt);
  state_.boulders.add_forces(state_.rigid_wall_forces);
  state_.boulders.accept();
  state_.surfaces.accept();
  state_.ledger.set_contact_energy(state_.surfaces.energy());
  state_.nearly_linear = false;
  state_.contact_rate = 0;
  under_way_ = false;
  AcceptReport report;
  report.details = {{"active_nodes", 0},
                    {"points_changed_cell", 0},
                    {"dt_limit", static_cast<int>(sizes_.proposal().limit)}};
  report.proposed_dt = sizes_.proposal().dt;
  return report;
}

template AcceptReport SoilStep<2>::accept_without_soil(double);
template AcceptReport SoilStep<3>::accept_without_soil(double);

}  // namespace gabion::mpm
