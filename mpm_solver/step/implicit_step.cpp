// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step/implicit_step.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "common/base/log.hpp"
#include "common/mechanics/materials/strength_reduction.hpp"
#include "mpm_solver/step/first_guess.hpp"

namespace gabion::mpm {

namespace {

// Share of Newton's tolerance that holds from the second iteration of a coupled step on: the error
// of a solution must not look like a change of the interface.
constexpr double coupled_share = 0.01;

// Difference of strain that the tangent of a known stress may bridge, as a share of Newton's
// relative tolerance. The error (of second order; of first order across the yield surface) stays
// below that tolerance, and below its coupled share.
constexpr double same_strain_share = 0.01 * coupled_share;

}  // namespace

template <int dim>
ImplicitStep<dim>::ImplicitStep(const Parts& parts)
    : parts_(parts), system_(parts.model.comm, parts.model.settings.linear_solver) {}

template <int dim>
void ImplicitStep<dim>::begin(const StepStart& start) {
  start_ = start;
  reduce_strength();
  const double end = start.time + start.dt;
  f_body_ = parts_.soil.body_forces(end);
  f_body_start_.clear();
  if (start.scheme.force_memory() != 0) f_body_start_ = parts_.soil.body_forces(start.time);
  const MpmSettings<dim>& settings = parts_.model.settings;
  const LoadRamp& ramp = settings.phases[start.phase].gravity_ramp;
  make_equilibrium(
      {.start = ramp.at(start.time) * settings.gravity, .end = ramp.at(end) * settings.gravity});
}

// Bodies with the strength of this step.
template <int dim>
void ImplicitStep<dim>::reduce_strength() {
  weaker_.clear();
  if (start_.strength_factor == 1) return;
  weaker_ = parts_.model.settings.bodies;
  for (Body<dim>& body : weaker_) {
    auto law = with_reduced_strength<dim>(body.material.law, start_.strength_factor);
    if (law) body.material.law = *std::move(law);
  }
  weaker_laws_ = parts_.soil.laws().reduced(start_.strength_factor);
}

template <int dim>
void ImplicitStep<dim>::make_equilibrium(const Gravity& gravity) {
  const ScopedTimer timer(parts_.times, "pattern");
  const SoilModel<dim>& model = parts_.model;
  const SoilState<dim>& state = parts_.state;
  equilibrium_.emplace(typename Equilibrium<dim>::Parts{
      .comm = model.comm,
      .grid = model.grid,
      .bodies = weaker_.empty() ? model.settings.bodies : weaker_,
      .points = state.points,
      .weights = parts_.soil.weights(),
      .nodes = parts_.soil.nodes(),
      .walls = parts_.soil.walls(start_.phase),
      .contacts = state.surfaces.contacts(),
      .trial = parts_.trial,
      .scheme = start_.scheme,
      .gravity = gravity.end,
      .gravity_start = gravity.start,
      .cell_size = model.cell_size,
      .same_strain = same_strain_share * model.settings.newton.residual_tolerance,
      .dt = start_.dt,
      .with_inertia = start_.with_inertia,
      .repeats = !model.settings.interfaces.empty() || !model.settings.boulders.empty(),
      .nearly_linear = state.nearly_linear,
      .f_body = f_body_,
      .f_body_start = f_body_start_,
      .f_pore = f_pore_,
      .average_volumes = model.settings.locking.average_volumes,
      .ghost = parts_.soil.ghost(),
      .laws = (weaker_.empty() ? parts_.soil.laws() : weaker_laws_).of_points(),
      .averages = model.settings.softening_averages});
  system_.begin(*equilibrium_, regime(), state.pause);
}

template <int dim>
LinearRegime ImplicitStep<dim>::regime() const {
  const SoilModel<dim>& model = parts_.model;
  const double courant = model.wave_speed * start_.dt / model.cell_size;
  return {.symmetric = model.symmetric_laws && parts_.state.surfaces.symmetric(),
          .courant = start_.with_inertia ? courant : std::numeric_limits<double>::infinity(),
          .wide = dim == 3 && model.grid.basis != Basis::linear};
}

template <int dim>
NewtonReport ImplicitStep<dim>::solve_balance(const StepRequest& request) {
  const bool first = request.iteration == 0;
  NewtonSettings settings = parts_.model.settings.newton;
  if (!start_.with_inertia) {
    settings.max_iterations = parts_.model.settings.iterations_without_inertia;
  }
  double& tolerance = settings.residual_tolerance;
  if (!first)
    tolerance = std::min(tolerance, std::max(coupled_share * tolerance, likely_round_off));
  const NewtonReport newton = iterate(first, settings);
  linear_iterations_ += newton.linear_iterations;
  if (first) first_iterations_ = newton.iterations;
  parts_.sizes.add_solution(newton.iterations);
  log::debug("step {} iteration {}: |r|/scale {:.1e}, {} linear iterations", request.step,
             request.iteration, fmt::join(newton.residuals, " "), newton.linear_iterations);
  return newton;
}

template <int dim>
NewtonReport ImplicitStep<dim>::iterate(bool first, const NewtonSettings& settings) {
  if (first) {
    equilibrium_->internal_forces().forget();
    FirstGuess guess = first_guess(*equilibrium_, system_, parts_.model.wave_speed, parts_.times);
    du_ = std::move(guess.du);
    linear_iterations_ += guess.linear_iterations;
  }
  equilibrium_->begin_solution();
  return system_.solve_newton(*equilibrium_, settings, du_, parts_.times);
}

template <int dim>
StepReport ImplicitStep<dim>::solve(const StepRequest& request) {
  const NewtonReport newton = solve_balance(request);
  StepReport report;
  report.newton_iterations = newton.iterations;
  report.linear_iterations = newton.linear_iterations;
  return report;
}

// 1 for nodes of points of any rank in contact with an interface, at the owners of the nodes.
template <int dim>
std::vector<char> ImplicitStep<dim>::touched_nodes() const {
  std::vector<char> touched(equilibrium_->inertia_mass().size(), 0);
  if (!parts_.state.surfaces.may_touch_interface()) return touched;
  parts_.state.surfaces.mark_touched(touched);
  const SharedNodes& shared = equilibrium_->shared();
  if (shared.alone()) return touched;
  std::vector<double> ranks(touched.begin(), touched.end());
  shared.add_to_owners(ranks, 1);
  std::ranges::transform(ranks, touched.begin(), [](double n) { return n > 0 ? 1 : 0; });
  return touched;
}

template <int dim>
StepEnd<dim> ImplicitStep<dim>::end() {
  equilibrium_->internal_forces().finish(du_);
  StepEnd<dim> end;
  end.motion = nodal_motion<dim>(*equilibrium_, du_);
  if (parts_.sizes.limits().time_error && start_.with_inertia && !start_.forces_jump) {
    end.error = step_error<dim>(*equilibrium_, end.motion, touched_nodes());
  }
  end.balance = step_balance(*equilibrium_, du(), end.motion);
  const MaterialPoints<dim>& points = parts_.state.points;
  end.plastic_work =
      plastic_work<dim>(parts_.soil.weights(), parts_.trial, points, parts_.model.settings.bodies);
  return end;
}

template <int dim>
void ImplicitStep<dim>::remember(SoilState<dim>& state) const {
  state.nearly_linear = first_iterations_ <= 1;
  state.contact_rate = 0;
  state.pause = system_.solver().pause();
}

template <int dim>
void ImplicitStep<dim>::release() {
  equilibrium_.reset();
  system_.release();
}

template <int dim>
std::vector<double> ImplicitStep<dim>::settlement(const StepStart& start,
                                                  const Vector<dim>& gravity,
                                                  const std::string& where) {
  start_ = start;
  make_equilibrium({.start = gravity, .end = gravity});
  std::vector<double> du(static_cast<std::size_t>(parts_.soil.nodes().size()) * dim, 0.0);
  std::vector<double> r(du.size());
  equilibrium_->evaluate(du, r, &system_.K());
  // K is singular when a part of the soil can move freely.
  try {
    system_.solve(r, du);
  } catch (const ConvergenceError& error) {
    const BodyGroups& groups = parts_.model.settings.body_groups;
    throw ConfigError(fmt::format(
        "{}: found no equilibrium of the soil under its initial stress: part of it is not held, or "
        "not against every rigid motion; allowed: bodies that rest on \"walls\" of the grid, or on "
        "bodies that do{} ({})",
        where,
        groups.any() ? ", in each of the \"contact_groups\": here no group bears another" : "",
        error.what()));
  }
  return du;
}

template class ImplicitStep<2>;
template class ImplicitStep<3>;

}  // namespace gabion::mpm
