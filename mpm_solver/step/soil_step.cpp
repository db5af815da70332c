// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step/soil_step.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/grid/noise_damping.hpp"
#include "mpm_solver/grid/point_domains.hpp"
#include "mpm_solver/step/end_of_step.hpp"
#include "mpm_solver/step/first_guess.hpp"
#include "mpm_solver/stress/point_motion.hpp"
#include "mpm_solver/stress/shared_volumes.hpp"

namespace gabion::mpm {

namespace {

// Share of Newton's tolerance that holds from the second iteration of a coupled step on: the error
// of a solution must not look like a change of the interface.
constexpr double coupled_share = 0.01;

// Strain that a known stress may be carried over, as a share of Newton's relative tolerance: what
// it can leave out (second order; first order across the yield surface) stays below that tolerance,
// and below its coupled share.
constexpr double same_strain_share = 0.01 * coupled_share;

// Newmark's method with these parameters asks for no acceleration at the start of a step:
// du = dt v + dt^2 a' / 2, v' = v + dt a'. For a first step whose forces are not those before it;
// and for the ledger of explicit steps and of those without inertia: the impulse of a force is dt
// F.
constexpr NewmarkBossak starting_scheme = {.beta = 0.5, .gamma = 1};

// Over all ranks [m].
template <int dim>
double mean_point_size(MPI_Comm comm, const MaterialPoints<dim>& points) {
  double sums[] = {0, static_cast<double>(points.size())};
  for (const double volume : points.V0) sums[0] += volume;
  sum_over_ranks(comm, std::span<double>(sums));
  return cube_side<dim>(sums[0] / sums[1]);
}

}  // namespace

template <int dim>
SoilStep<dim>::SoilStep(const SoilModel<dim>& model, SoilState<dim>& state, PhaseTimes& times)
    : model_(model),
      state_(state),
      times_(times),
      soil_(model, state, times),
      sizes_(state.control),
      system_(model.comm, model.settings.linear_solver),
      rotations_(model.comm, model.settings.bodies),
      explicit_(model, state, times) {
  if (!state_.surfaces.contacts().empty()) {
    reach_ = 0.5 * mean_point_size(model_.comm, state_.points);
  }
  soil_.weigh();
}

// Which phase it is, and how its step goes.
template <int dim>
void SoilStep<dim>::enter_phase(double time) {
  const auto& phases = model_.settings.phases;
  const std::size_t before = phase_;
  phase_ = phase_at(phases, time);
  if (phase_ != before) {
    const char* kind = phase().is_explicit() ? "explicit"
                       : phase().dynamic     ? "dynamic"
                                             : "quasi-static";
    log::info("{:.6g} s: phase {} of {}, {}, {} walls", time, phase_ + 1, phases.size(), kind,
              phase().walls.size());
  }
  if (phase().rigid_walls) state_.surfaces.keep_walls(*phase().rigid_walls);
  with_inertia_ = phase().dynamic;
  forces_jump_ = begins(phase(), time) && (phase_ > 0 || model_.stressed);
  const bool as_ever = with_inertia_ && !forces_jump_ && !phase().is_explicit();
  scheme_ = as_ever ? phase().scheme : starting_scheme;
}

// Everything of a step that does not depend on the interface values.
template <int dim>
void SoilStep<dim>::begin(const StepRequest& request) {
  const double end = request.time + request.dt;
  enter_phase(request.time);
  require_within(phase(), request.time, request.dt);
  soil_.walls(phase_).begin_step(request.time, request.dt);
  dt_ = request.dt;
  map_soil(request.dt);
  f_body_ = soil_.body_forces(end);
  f_body_start_.clear();
  if (scheme_.force_memory() != 0 || phase().is_explicit()) {
    f_body_start_ = soil_.body_forces(request.time);
  }
  if (phase().is_explicit()) {
    begin_explicit(request);
    return;
  }
  const LoadRamp& ramp = phase().gravity_ramp;
  const Vector<dim>& gravity = model_.settings.gravity;
  make_equilibrium(ramp.at(request.time) * gravity, ramp.at(end) * gravity, request.dt);
}

template <int dim>
void SoilStep<dim>::begin_explicit(const StepRequest& request) {
  equilibrium_.reset();
  if (!state_.surfaces.contacts().empty()) {
    state_.surfaces.begin_step(surface_of_soil(request.dt));
  }
  explicit_.begin(request, {.phase = phase(),
                            .soil = soil_,
                            .walls = soil_.walls(phase_),
                            .trial = trial_,
                            .f_body_start = f_body_start_,
                            .f_body = f_body_});
}

template <int dim>
LinearRegime SoilStep<dim>::regime() const {
  const bool symmetric = model_.symmetric_laws && state_.surfaces.symmetric();
  const double courant = model_.wave_speed * dt_ / model_.cell_size;
  return {.symmetric = symmetric,
          .courant = with_inertia_ ? courant : std::numeric_limits<double>::infinity(),
          .wide = dim == 3 && model_.grid.basis != Basis::linear};
}

template <int dim>
SoilSurface<dim> SoilStep<dim>::surface_of_soil(double dt) const {
  return {.grid = model_.grid,
          .nodes = soil_.nodes(),
          .points = state_.points,
          .weights = soil_.weights(),
          .occupied = &occupied_,
          .reach = reach_,
          .cell_size = model_.cell_size,
          .dt = dt,
          .step_force_weight = with_inertia_ ? scheme_.step_force_weight() : 1,
          .elastic = model_.elastic,
          .moduli = model_.moduli,
          .comm = model_.comm};
}

template <int dim>
void SoilStep<dim>::map_soil(double dt) {
  std::vector<std::int32_t> other_nodes;
  if (state_.surfaces.asks_for_cells()) {
    occupied_ = soil_.occupied_cells();
    if (num_ranks(model_.comm) > 1) other_nodes = state_.surfaces.find_nodes(surface_of_soil(dt));
  }
  soil_.map({.phase = phase_,
             .dt = dt,
             .with_inertia = with_inertia_,
             .other_nodes = std::move(other_nodes)});
}

/// @param gravity_n, gravity  at the start and at the end of the step
template <int dim>
void SoilStep<dim>::make_equilibrium(const Vector<dim>& gravity_n, const Vector<dim>& gravity,
                                     double dt) {
  const ScopedTimer timer(times_, "pattern");
  if (!state_.surfaces.contacts().empty()) state_.surfaces.begin_step(surface_of_soil(dt));
  equilibrium_.emplace(typename Equilibrium<dim>::Parts{
      .comm = model_.comm,
      .grid = model_.grid,
      .bodies = model_.settings.bodies,
      .points = state_.points,
      .weights = soil_.weights(),
      .nodes = soil_.nodes(),
      .walls = soil_.walls(phase_),
      .contacts = state_.surfaces.contacts(),
      .trial = trial_,
      .scheme = scheme_,
      .gravity = gravity,
      .gravity_start = gravity_n,
      .cell_size = model_.cell_size,
      .same_strain = same_strain_share * model_.settings.newton.residual_tolerance,
      .dt = dt,
      .with_inertia = with_inertia_,
      .repeats = !model_.settings.interfaces.empty(),
      .nearly_linear = state_.nearly_linear,
      .f_body = f_body_,
      .f_body_start = f_body_start_,
      .average_volumes = model_.settings.locking.average_volumes,
      .ghost = soil_.ghost()});
  system_.begin(*equilibrium_, regime(), state_.pause);
}

template <int dim>
NewtonReport SoilStep<dim>::solve_balance(const StepRequest& request, bool begins) {
  const bool first = begins || request.iteration == 0;
  if (first) {
    equilibrium_->internal_forces().forget();
    FirstGuess guess = first_guess(*equilibrium_, system_, model_.wave_speed, times_);
    du_ = std::move(guess.du);
    linear_iterations_ += guess.linear_iterations;
  }
  equilibrium_->begin_solution();
  NewtonSettings settings = model_.settings.newton;
  if (!with_inertia_) settings.max_iterations = model_.settings.iterations_without_inertia;
  double& tolerance = settings.residual_tolerance;
  if (request.iteration > 0) {
    tolerance = std::min(tolerance, std::max(coupled_share * tolerance, likely_round_off));
  }
  const NewtonReport newton = system_.solve_newton(*equilibrium_, settings, du_, times_);
  linear_iterations_ += newton.linear_iterations;
  if (first) first_iterations_ = newton.iterations;
  sizes_.add_solution(newton.iterations);
  log::debug("step {} iteration {}: |r|/scale {:.1e}, {} linear iterations", request.step,
             request.iteration, fmt::join(newton.residuals, " "), newton.linear_iterations);
  return newton;
}

template <int dim>
StepReport SoilStep<dim>::solve_implicit(const StepRequest& request, bool begins) {
  const NewtonReport newton = solve_balance(request, begins);
  StepReport report;
  report.newton_iterations = newton.iterations;
  report.linear_iterations = newton.linear_iterations;
  return report;
}

template <int dim>
StepReport SoilStep<dim>::solve_explicit(const StepRequest& request) {
  explicit_.solve(request);
  du_ = explicit_.du();
  return {};
}

template <int dim>
StepReport SoilStep<dim>::solve(const StepRequest& request, const InterfaceValues& received) {
  try {
    if (state_.is_empty()) return solve_without_soil(request, received);
    const bool begins = dt_ != request.dt;
    if (begins) {
      sizes_.begin(request);
      begin(request);
    }
    state_.surfaces.receive(received);
    state_.surfaces.move_walls(request.time + request.dt);
    StepReport report =
        phase().is_explicit() ? solve_explicit(request) : solve_implicit(request, begins);
    if (model_.settings.outside == Outside::error) soil_.refuse_exits(phase(), du_);
    if (state_.surfaces.look_ahead()) {
      state_.surfaces.refuse_misses(largest_surplus_way(
          state_.points, soil_.weights(), soil_.nodes(), std::span<const double>(du_), request.dt));
    }
    state_.surfaces.report(report);
    return report;
  } catch (const ConvergenceError& error) {
    sizes_.add_failure(error, request.dt);
    throw;
  }
}

template <int dim>
AcceptReport SoilStep<dim>::accept(const StepRequest& request, bool solved) {
  require(solved && dt_ == request.dt, "mpm_solver: a step was accepted that was not solved");
  if (state_.is_empty()) return accept_without_soil(request);
  const ScopedTimer timer(times_, "grid to points");
  MaterialPoints<dim>& points = state_.points;
  state_.wall_forces = forces_on_walls();
  state_.rigid_wall_forces = state_.surfaces.forces_on_walls();
  const bool implicit = equilibrium_.has_value();
  if (implicit) equilibrium_->internal_forces().finish(du_);
  const double time = request.time + request.dt;
  const auto& phases = model_.settings.phases;
  const NodalMotion<dim> motion =
      implicit ? nodal_motion<dim>(*equilibrium_, du_) : explicit_.nodal_motion();
  sizes_.accept(measure(motion), largest_step(phases[phase_at(phases, time)], time));
  StepBalance<dim> balance = implicit
                                 ? step_balance(*equilibrium_, std::span<const double>(du_), motion)
                                 : explicit_.balance();
  add_stop<dim>(soil_.stop().totals(), model_.settings.pic_share, balance);
  deform_points<dim>(soil_.nodes(), du_, soil_.weights(), points);
  capped_domains_ += soil_.weights().num_capped;
  std::vector<Vector<dim>> x_n;
  if (model_.lets_out || !model_.settings.gauges.empty()) x_n = points.x;
  soil_.stop().kick(soil_.weights(), points);
  grid_to_points(soil_.nodes(), motion, soil_.weights(), model_.settings.pic_share, points);
  if (!implicit) explicit_.finish_points(points);
  if (with_inertia_) {
    const NoiseDamping rate{model_.settings.noise_damping, dt_, model_.cell_size};
    if (rate.damping > 0) damp_noise<dim>(soil_.weights(), soil_.nodes(), rate, points);
  } else {
    std::fill(points.v.begin(), points.v.end(), Vector<dim>::Zero());
    std::fill(points.a.begin(), points.a.end(), Vector<dim>::Zero());
  }
  const double dissipated =
      implicit ? plastic_work<dim>(soil_.weights(), trial_, points, model_.settings.bodies)
               : explicit_.plastic_work();
  balance.quadrature_loss = unstored_work(soil_.weights(), trial_, points);
  accept_stresses(soil_.weights(), trial_, points);
  const std::vector<std::int32_t> cell_n = points.cell;
  const auto outside = find_cells(model_.grid, points);
  if (model_.settings.locking.average_volumes) {
    balance.sharing_loss = share_volumes(state_.ranks.owners(), model_.settings.bodies, points);
  }
  state_.gauges.add_step(x_n, points, dt_);
  state_.ledger.add_step(balance, with_inertia_ ? scheme_ : starting_scheme, dt_, dissipated,
                         points);
  rotations_.look(points);
  state_.surfaces.accept();
  state_.ledger.set_contact_energy(state_.surfaces.energy());
  state_.nearly_linear = implicit && first_iterations_ <= 1;
  state_.contact_rate = implicit ? 0 : explicit_.contact_rate();
  state_.pause = system_.solver().pause();
  dt_ = 0;
  AcceptReport report;
  report.details = details(cell_n);
  report.proposed_dt = sizes_.proposal().dt;
  state_.remove(outside, {.x = x_n, .cell = cell_n, .time = time}, model_);
  state_.ranks.follow(points, state_.surfaces);
  return report;
}

template <int dim>
void SoilStep<dim>::reject() {
  dt_ = 0;
  sizes_.reject();
}

template <int dim>
StepMeasures SoilStep<dim>::measure(const NodalMotion<dim>& motion) const {
  const StepControlSettings& limits = sizes_.limits();
  const std::span<const double> du(du_);
  StepMeasures step;
  step.dt = dt_;
  if (limits.time_error && with_inertia_ && !forces_jump_ && equilibrium_) {
    const StepError error = step_error(*equilibrium_, motion);
    step.error = error.displacement;
    const double fall = std::sqrt(model_.settings.gravity.norm() * model_.cell_size);
    step.speed = std::max(error.speed, fall);
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
    step.approach_dt = state_.surfaces.approach_step(dt_, *limits.approach * model_.cell_size);
  }
  return step;
}

template <int dim>
std::vector<Vector<dim>> SoilStep<dim>::forces_on_walls() const {
  const auto& groups = model_.wall_groups;
  std::vector<Vector<dim>> sums(groups.size(), Vector<dim>::Zero());
  auto forces = equilibrium_ ? equilibrium_->wall_forces() : explicit_.wall_forces();
  soil_.add_stopping_forces(phase_, dt_, forces);
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
