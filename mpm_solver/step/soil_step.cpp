// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step/soil_step.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/checks/pools.hpp"
#include "mpm_solver/checks/seepage.hpp"
#include "mpm_solver/contact/pool_forces.hpp"
#include "mpm_solver/grid/noise_damping.hpp"
#include "mpm_solver/grid/point_domains.hpp"
#include "mpm_solver/step/seepage_step.hpp"
#include "mpm_solver/stress/nonlocal_slip.hpp"
#include "mpm_solver/stress/point_motion.hpp"
#include "mpm_solver/stress/shared_volumes.hpp"

namespace gabion::mpm {

namespace {

// Share of a cell by which the soil may see boulders away from their places.
constexpr double boulder_tolerance = 1e-5;

// Side of a cube with the mean volume of the points of all ranks [m].
template <int dim>
double mean_point_size(MPI_Comm comm, const MaterialPoints<dim>& points) {
  double sums[] = {0, static_cast<double>(points.size())};
  for (const double volume : points.V0) sums[0] += volume;
  sum_over_ranks(comm, std::span<double>(sums));
  return cube_side<dim>(sums[0] / sums[1]);
}

template <int dim>
std::unique_ptr<ImplicitStep<dim>> make_implicit(const typename StepMethod<dim>::Parts& parts) {
  if (parts.model.drains) return std::make_unique<SeepageStep<dim>>(parts);
  return std::make_unique<ImplicitStep<dim>>(parts);
}

template <int dim>
bool takes_weight(const Vector<dim>& gravity, const Phase& phase, double time) {
  if (gravity.isZero(0)) return false;
  return !phase.dynamic || phase.gravity_ramp.runs(time);
}

}  // namespace

template <int dim>
SoilStep<dim>::SoilStep(const SoilModel<dim>& model, SoilState<dim>& state, PhaseTimes& times)
    : model_(model),
      state_(state),
      times_(times),
      soil_(model, state, times),
      sizes_(state.control),
      rotations_(model.comm, model.settings.bodies),
      implicit_(make_implicit<dim>({model, state, soil_, trial_, sizes_, times})),
      explicit_({model, state, soil_, trial_, sizes_, times}) {
  if (!state_.surfaces.contacts().empty()) {
    reach_ = 0.5 * mean_point_size(model_.comm, state_.points);
  }
  soil_.weigh();
}

template <int dim>
StepMethod<dim>& SoilStep<dim>::method_of(const Phase& phase) {
  if (phase.is_explicit()) return explicit_;
  return *implicit_;
}

// Enter the phase of the step, with its method and scheme.
template <int dim>
void SoilStep<dim>::enter_phase(const StepRequest& request) {
  const auto& phases = model_.settings.phases;
  const double time = request.time;
  const std::size_t number = phase_at(phases, time);
  const Phase& phase = phases[number];
  if (number != start_.phase) {
    const char* kind = phase.is_explicit() ? "explicit"
                       : phase.dynamic     ? "dynamic"
                                           : "quasi-static";
    log::info("{:.6g} s: phase {} of {}, {}, {} walls", time, number + 1, phases.size(), kind,
              phase.walls.size());
  }
  if (phase.rigid_walls) state_.surfaces.keep_walls(*phase.rigid_walls);
  StepMethod<dim>* const before = std::exchange(method_, &method_of(phase));
  if (before != nullptr && before != method_) before->release();
  const bool forces_jump = begins(phase, time) && (number > 0 || model_.stressed);
  start_ = {.time = time,
            .dt = request.dt,
            .phase = number,
            .with_inertia = phase.dynamic,
            .forces_jump = forces_jump,
            .takes_weight = takes_weight(model_.settings.gravity, phase, time),
            .scheme = method_->scheme(phase, forces_jump)};
  if (!phase.strength_reduction) return;
  if (strength_.phase() != static_cast<int>(number)) {
    strength_.start(*phase.strength_reduction, static_cast<int>(number));
  }
  start_.strength_factor = strength_.next(*phase.strength_reduction);
}

template <int dim>
void SoilStep<dim>::begin(const StepRequest& request) {
  begin_with(request, state_.strength);
}

template <int dim>
void SoilStep<dim>::begin_with(const StepRequest& request, const StrengthSearch& search) {
  strength_ = search;
  under_way_ = false;
  surplus_.forget();
  sizes_.begin(request);
  enter_phase(request);
  require_within(phase(), request.time, request.dt);
  if (!state_.is_empty()) {
    soil_.walls(start_.phase).begin_step(request.time, request.dt);
    map_soil();
    set_nonlocal_slip<dim>(model_.settings.softening_averages, soil_.weights(), soil_.nodes(),
                           state_.points);
    begin_surfaces();
    method_->begin(start_);
  }
  under_way_ = true;
}

template <int dim>
SoilSurface<dim> SoilStep<dim>::surface_of_soil() const {
  return {.grid = model_.grid,
          .nodes = soil_.nodes(),
          .points = state_.points,
          .weights = soil_.weights(),
          .occupied = &occupied_,
          .reach = reach_,
          .cell_size = model_.cell_size,
          .dt = start_.dt,
          .step_force_weight = start_.with_inertia ? start_.scheme.step_force_weight() : 1,
          .elastic = model_.elastic,
          .moduli = model_.moduli,
          .strength_factor = start_.strength_factor,
          .takes_weight = start_.takes_weight,
          .weights_of = model_.weights,
          .pore_pressures = pore_pressures_,
          .grain_stresses = grain_stresses_,
          .pore_waters = pore_waters_,
          .comm = model_.comm};
}

template <int dim>
void SoilStep<dim>::map_soil() {
  std::vector<std::int32_t> other_nodes;
  if (state_.surfaces.asks_for_cells()) {
    occupied_ = soil_.occupied_cells();
    if (num_ranks(model_.comm) > 1) other_nodes = state_.surfaces.find_nodes(surface_of_soil());
  }
  soil_.map({.phase = start_.phase,
             .dt = start_.dt,
             .with_inertia = start_.with_inertia,
             .other_nodes = std::move(other_nodes)});
}

template <int dim>
void SoilStep<dim>::begin_surfaces() {
  if (state_.surfaces.contacts().empty()) return;
  find_pore_pressures();
  const ScopedTimer timer(times_, "contact search");
  state_.surfaces.begin_step(surface_of_soil());
}

template <int dim>
StepReport SoilStep<dim>::solve(const StepRequest& request, const InterfaceValues& received) {
  require(under_way_ && start_.time == request.time && start_.dt == request.dt,
          "mpm_solver: iteration {} of step {}, from {} s with dt {} s, was asked for before its "
          "iteration 0",
          request.iteration, request.step, request.time, request.dt);
  return phase().strength_reduction ? solve_weaker(request, received)
                                    : solve_once(request, received);
}

template <int dim>
StepReport SoilStep<dim>::solve_once(const StepRequest& request, const InterfaceValues& received) {
  const double end = request.time + request.dt;
  if (!model_.settings.pools.empty()) state_.surfaces.set_pools(pools_at(end));
  state_.surfaces.receive(received);
  state_.surfaces.move_walls(end);
  StepReport report =
      state_.boulders.empty() ? solve_soil(request) : solve_with_boulders(request, received);
  state_.surfaces.report(report);
  report.interface_active |= state_.boulders.may_touch_interface();
  return report;
}

template <int dim>
StepReport SoilStep<dim>::solve_soil(const StepRequest& request) {
  if (state_.is_empty()) return {};
  StepReport report = method_->solve(request);
  if (model_.settings.outside == Outside::error) soil_.refuse_exits(phase(), method_->du());
  check_surfaces();
  return report;
}

// Solve for soil and boulders in turn, until the boulders are where the soil saw them.
template <int dim>
StepReport SoilStep<dim>::solve_with_boulders(const StepRequest& request,
                                              const InterfaceValues& received) {
  Boulders<dim>& boulders = state_.boulders;
  boulders.begin({.time = request.time,
                  .dt = request.dt,
                  .phase = &phase(),
                  .received = &received,
                  .tolerance = boulder_tolerance * model_.cell_size});
  StepReport report;
  StepRequest pass = request;
  for (bool agree = false; !agree; ++pass.iteration) {
    boulders.place(state_.surfaces);
    report = solve_soil(pass);
    agree = boulders.follow(state_.surfaces.forces_on_walls());
  }
  if (model_.settings.outside == Outside::error) boulders.refuse_exits();
  return report;
}

// Check that the search missed no contact of the solution.
template <int dim>
void SoilStep<dim>::check_surfaces() {
  if (!state_.surfaces.look_ahead()) return;
  state_.surfaces.refuse_misses(
      surplus_.largest({state_.points, soil_.weights(), soil_.nodes(), method_->du(), start_.dt}));
}

template <int dim>
AcceptReport SoilStep<dim>::accept(const StepRequest& request, bool solved) {
  require(solved && under_way_ && start_.dt == request.dt,
          "mpm_solver: a step was accepted that was not solved");
  const double time = request.time + request.dt;
  if (state_.is_empty()) return accept_without_soil(time);
  const ScopedTimer timer(times_, "grid to points");
  MaterialPoints<dim>& points = state_.points;
  state_.wall_forces = forces_on_walls(*method_, time);
  state_.rigid_wall_forces = state_.surfaces.forces_on_walls();
  state_.boulders.add_forces(state_.rigid_wall_forces);
  StepEnd<dim> end = method_->end();
  sizes_.accept(measure(end), largest_step_from(time));
  add_stop<dim>(soil_.stop().totals(), model_.settings.pic_share, end.balance);
  std::vector<Vector<dim>> x_n;
  if (model_.lets_out || !model_.settings.gauges.empty()) x_n = points.x;
  move_points(end);
  end.balance.quadrature_loss = unstored_work(soil_.weights(), trial_, points);
  accept_stresses(soil_.weights(), trial_, points);
  const std::vector<std::int32_t> cell_n = points.cell;
  const auto outside = find_cells(model_.grid, points);
  if (model_.settings.locking.average_volumes) {
    end.balance.sharing_loss =
        share_volumes(state_.ranks.owners(), model_.settings.bodies, points,
                      soil_.laws().of_points(), model_.settings.softening_averages);
  }
  state_.gauges.add_step(x_n, points, start_.dt);
  state_.ledger.add_step(end.balance, start_.scheme, start_.dt, end.plastic_work, points);
  rotations_.look(points);
  state_.surfaces.accept();
  state_.boulders.accept();
  state_.ledger.set_contact_energy(state_.surfaces.energy());
  method_->remember(state_);
  state_.strength = strength_;
  under_way_ = false;
  AcceptReport report;
  report.details = details(cell_n);
  report.proposed_dt = sizes_.proposal().dt;
  state_.remove(outside, {.x = x_n, .cell = cell_n, .time = time}, model_);
  state_.ranks.follow(points, state_.surfaces);
  return report;
}

// Move the points (G2P): position, velocity and acceleration, and their domains.
template <int dim>
void SoilStep<dim>::move_points(const StepEnd<dim>& end) {
  MaterialPoints<dim>& points = state_.points;
  deform_points<dim>(soil_.nodes(), method_->du(), soil_.weights(), points);
  capped_domains_ += soil_.weights().num_capped;
  soil_.stop().kick(soil_.weights(), points);
  grid_to_points(soil_.nodes(), end.motion, soil_.weights(), model_.settings.pic_share, points);
  method_->finish_points(points);
  if (start_.with_inertia) {
    const double damping = model_.settings.noise_damping;
    if (damping > 0) {
      const std::vector<double> pools = pool_pressures();
      const NoiseDamping rate{damping, start_.dt, model_.cell_size, pools};
      damp_noise<dim>(soil_.weights(), soil_.nodes(), rate, points);
    }
  } else {
    std::fill(points.v.begin(), points.v.end(), Vector<dim>::Zero());
    std::fill(points.a.begin(), points.a.end(), Vector<dim>::Zero());
  }
}

template <int dim>
void SoilStep<dim>::reject() {
  under_way_ = false;
  sizes_.reject();
}

template <int dim>
void SoilStep<dim>::release() {
  if (under_way_) return;
  implicit_->release();
  explicit_.release();
  trial_ = {};
  soil_.release();
}

template <int dim>
double SoilStep<dim>::largest_step_from(double time) const {
  const auto& phases = model_.settings.phases;
  return largest_step(phases[phase_at(phases, time)], time);
}

template <int dim>
StepMeasures SoilStep<dim>::measure(const StepEnd<dim>& end) const {
  const StepControlSettings& limits = sizes_.limits();
  const std::span<const double> du = method_->du();
  StepMeasures step;
  step.dt = start_.dt;
  if (end.error) {
    step.error = end.error->displacement;
    const double fall = std::sqrt(model_.settings.gravity.norm() * model_.cell_size);
    step.speed = std::max(end.error->speed, fall);
  }
  if (limits.advective) {
    const double largest =
        max_over_ranks(model_.comm, largest_displacement(soil_.weights(), soil_.nodes(), du));
    step.travel = largest / model_.cell_size;
  }
  if (limits.strain) {
    step.strain =
        max_over_ranks(model_.comm, most_strained(soil_.weights(), soil_.nodes(), du).strain);
  }
  if (limits.approach && !state_.surfaces.contacts().empty()) {
    step.approach_dt =
        state_.surfaces.approach_step(start_.dt, *limits.approach * model_.cell_size);
  }
  return step;
}

template <int dim>
std::vector<Vector<dim>> SoilStep<dim>::forces_on_walls(const StepMethod<dim>& method,
                                                        double time) const {
  const auto& groups = model_.wall_groups;
  std::vector<Vector<dim>> sums(groups.size(), Vector<dim>::Zero());
  auto forces = method.wall_forces();
  soil_.add_stopping_forces(start_.phase, start_.dt, forces);
  const PoolLevels pools = pools_at(time);
  for (std::size_t w = 0; w < forces.size() && !pools.empty(); ++w) {
    const WallSettings& wall = phase().walls[w];
    forces[w] += pool_force_on_sides<dim>(
        pools, *model_.grid.box, find_facets(model_.grid.facet_groups, wall.group, wall.where));
  }
  for (std::size_t w = 0; w < forces.size(); ++w) {
    const auto place = std::find(groups.begin(), groups.end(), phase().walls[w].group);
    sums[static_cast<std::size_t>(place - groups.begin())] += forces[w];
  }
  return sums;
}

/// Numbers of the step that was just accepted. @param cell_n  of each point before the step
template <int dim>
Json SoilStep<dim>::details(std::span<const std::int32_t> cell_n) const {
  double smallest = std::numeric_limits<double>::infinity();
  for (const double J_ratio : trial_.J_ratio) smallest = std::min(smallest, J_ratio);
  std::int32_t moved = 0;
  for (std::size_t p = 0; p < cell_n.size(); ++p) moved += state_.points.cell[p] != cell_n[p];
  sum_over_ranks(model_.comm, std::span<std::int32_t>(&moved, 1));
  return {{"min_J_ratio", -max_over_ranks(model_.comm, -smallest)},
          {"active_nodes", soil_.nodes().num_of_all()},
          {"points_changed_cell", moved},
          {"dt_limit", static_cast<int>(sizes_.proposal().limit)}};
}

template class SoilStep<2>;
template class SoilStep<3>;

}  // namespace gabion::mpm
