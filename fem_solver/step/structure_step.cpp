// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/step/structure_step.hpp"

#include <algorithm>
#include <cassert>
#include <limits>

#include "common/base/require.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "common/mechanics/time_integration/step_force_filter.hpp"
#include "fem_solver/step/full_steps.hpp"
#include "fem_solver/step/kept_factor.hpp"
#include "fem_solver/step/start_values.hpp"
#include "fem_solver/step/static_newton.hpp"
#include "fem_solver/step/step_work.hpp"

namespace gabion::fem {

template <int dim>
StructureStep<dim>::StructureStep(const FemSettings<dim>& settings, MPI_Comm comm)
    : dynamic_(settings.dynamic),
      initial_equilibrium_(settings.initial_equilibrium),
      initial_velocity_(settings.initial_velocity),
      num_places_(static_cast<std::size_t>(settings.num_places())),
      beams_(settings.beam_nodes().any()),
      slender_(is_slender(settings.mesh, settings.ranks)),
      newton_(settings.newton),
      static_newton_(static_newton(settings)),
      conditions_(settings),
      equilibrium_(settings, conditions_, comm),
      linear_(comm, dim, full_step_solver(settings)),
      stability_(settings),
      weight_(gravity_forces(settings, equilibrium_)) {
  equilibrium_.set_pattern(K_);
  linear_.set_coordinates(coordinates_of(settings));
  linear_.accept_round_off();  // Newton's method checks the forces
}

template <int dim>
ExternalForces StructureStep<dim>::external_forces(double time,
                                                   const ExternalForces& f_interface) const {
  ExternalForces f{.end = weight_, .step = f_interface.step};
  f.step.resize(f.end.size(), 0.0);
  conditions_.add_loads(time, f.end);
  assert(f_interface.end.empty() || f_interface.end.size() == f.end.size());
  for (std::size_t i = 0; i < f_interface.end.size(); ++i) f.end[i] += f_interface.end[i];
  return f;
}

/// Loads of the balance at the end of the step, the mean forces with the weights of NewmarkBossak.
template <int dim>
std::vector<double> StructureStep<dim>::balanced_forces(const StructureState& state_n,
                                                        const ExternalForces& f) const {
  const double c = dynamic_ ? equilibrium_.scheme().step_force_weight() : 1;
  std::vector<double> sum = f.end;
  for (std::size_t i = 0; i < sum.size(); ++i) {
    sum[i] += c * f.step[i] - (c - 1) * state_n.f_step[i];
  }
  return sum;
}

template <int dim>
StructureState StructureStep<dim>::state_of(std::vector<double> u, std::vector<double> v) {
  StructureState state;
  state.f_ext = external_forces(0, {}).end;
  state.f_step.assign(equilibrium_.num_dofs(), 0.0);
  const auto constrained_u = conditions_.displacements(0);
  const auto dofs = conditions_.constrained_dofs();
  for (std::size_t k = 0; k < dofs.size(); ++k) {
    u[dofs[k]] = constrained_u[k];
    v[dofs[k]] = 0;
  }
  for (auto* y : {&u, &v}) equilibrium_.embedded().follow(*y);
  state.motion = {.u = std::move(u), .v = std::move(v), .a = {}};
  equilibrium_.set_history(nullptr);
  if (dynamic_) {
    state.motion.a = equilibrium_.initial_acceleration(state.motion, state.f_ext);
    equilibrium_.embedded().follow(state.motion.a);
    state.balanced = true;
  } else {
    state.motion.a.assign(equilibrium_.num_dofs(), 0.0);
  }
  std::vector<double> r(equilibrium_.num_dofs()), no_increment(equilibrium_.num_dofs(), 0.0);
  equilibrium_.begin_step(state.motion, state.f_ext, no_increment, 1, /*with_inertia=*/false);
  const Evaluation start = equilibrium_.evaluate(no_increment, r, nullptr);
  require<ConvergenceError>(start.admissible, "initial state: " + start.reason);
  state.f_int = equilibrium_.forces().internal;
  equilibrium_.add_damping(state.motion.v, state.f_int);
  state.reactions.assign(equilibrium_.num_dofs(), 0.0);
  const std::vector<double> inertia = equilibrium_.mass_times(state.motion.a);
  for (const auto dof : dofs) {
    state.reactions[dof] = state.f_int[dof] + inertia[dof] - state.f_ext[dof];
  }
  state.elastic_energy = equilibrium_.forces().elastic_energy;
  equilibrium_.find_history(state, nullptr);
  if (!dynamic_) state.balanced = shared().all(std::ranges::all_of(r, is_zero));
  return state;
}

template <int dim>
StructureState StructureStep<dim>::initial_state() {
  std::vector<double> u(equilibrium_.num_dofs(), 0.0), v(equilibrium_.num_dofs());
  for (std::size_t i = 0; i < num_places_ * dim; ++i) v[i] = initial_velocity_[i % dim];
  if (!initial_equilibrium_) {
    StructureState state = state_of(std::move(u), std::move(v));
    if (dynamic_) state.external_work = work_before_start(equilibrium_, conditions_, state);
    return state;
  }
  const ExternalForces f = external_forces(0, {});
  const StructureState reference = reference_state(f.end, equilibrium_.set_history(nullptr));
  StructureState state;
  if (nothing_changes(reference, f, conditions_.displacements(0)) &&
      is_without_forces(reference, equilibrium_)) {
    state = reference;
  } else {
    std::vector<double> du = first_guess(reference, 0);
    approach(reference, reference.f_ext, 1, /*with_inertia=*/false, du);
    solve_balance(reference, reference.f_ext, 1, /*with_inertia=*/false, du);
    fill_trial(reference, f, 0, du, state);
    stability_.look_at(reference, state, equilibrium_);
  }
  state.balanced = true;
  state.external_work = 0;
  state.tangent.reset();
  state.rescue.reset();
  return state;
}

/// Forces at the start of the step that the balance needs, see NewmarkBossak.
template <int dim>
std::vector<double> StructureStep<dim>::start_forces(const StructureState& state_n,
                                                     bool with_inertia) const {
  if (!with_inertia) return state_n.f_int;
  if (equilibrium_.scheme().force_memory() == 0) return {};
  std::vector<double> f = state_n.f_ext;
  for (std::size_t i = 0; i < f.size(); ++i) f[i] -= state_n.f_int[i];
  return f;
}

template <int dim>
bool StructureStep<dim>::nothing_changes(const StructureState& state_n, const ExternalForces& f,
                                         std::span<const double> constrained_u) const {
  const auto dofs = conditions_.constrained_dofs();
  bool same = true;
  for (std::size_t k = 0; k < dofs.size() && same; ++k) {
    same = constrained_u[k] == state_n.motion.u[dofs[k]] ||
           equilibrium_.embedded().contains(static_cast<std::int32_t>(dofs[k] / dim));
  }
  return shared().all(same && state_n.motion.is_still() && f.end == state_n.f_ext &&
                      f.step == state_n.f_step);
}

/// Guess: free components keep their velocity, or stay; constrained ones reach their prescribed
/// value.
template <int dim>
std::vector<double> StructureStep<dim>::first_guess(const StructureState& state_n, double dt,
                                                    bool moving) const {
  std::vector<double> du(equilibrium_.num_dofs(), 0.0);
  if (dynamic_ && moving) {
    for (std::size_t i = 0; i < du.size(); ++i) du[i] = dt * state_n.motion.v[i];
  }
  const auto constrained_u = conditions_.displacements(state_n.time + dt);
  const auto dofs = conditions_.constrained_dofs();
  for (std::size_t k = 0; k < dofs.size(); ++k) {
    du[dofs[k]] = constrained_u[k] - state_n.motion.u[dofs[k]];
  }
  return du;
}

/// @returns whether the linear solver holds the matrix that this solution starts with
template <int dim>
bool StructureStep<dim>::prepare_matrix(const StructureState& state_n, double dt,
                                        bool with_inertia) {
  const double courant = with_inertia
                             ? equilibrium_.wave_speed() * dt / equilibrium_.increment_scale()
                             : std::numeric_limits<double>::infinity();
  if (!last_) linear_.begin_step(state_n.pause);
  linear_.set_regime(
      {.symmetric = equilibrium_.symmetric(), .courant = courant, .slender = slender_},
      equilibrium_.num_nodes_of_all());
  const auto fits = [&](const std::optional<TangentPoint>& point) {
    return point && point->with_inertia == with_inertia && (!with_inertia || point->dt == dt);
  };
  if (!newton_.reuse_matrix) return false;
  if (last_) return fits(held_tangent_);
  if (!fits(state_n.tangent)) return false;
  if (shared().all(state_n.tangent == held_tangent_)) {
    linear_.set_rescue(state_n.rescue);
    return true;
  }
  const ScopedTimer timer(times_, "restore");
  held_tangent_ = state_n.tangent;
  equilibrium_.set_history(held_tangent_->history);
  equilibrium_.assemble_tangent(held_tangent_->u, dt, with_inertia, K_);
  linear_.set_matrix(K_, shared());
  linear_.set_rescue(state_n.rescue);
  ++restored_matrices_;
  return true;
}

template <int dim>
NewtonReport StructureStep<dim>::solve_balance(const StructureState& state_n,
                                               std::span<const double> f_ext, double dt,
                                               bool with_inertia, std::vector<double>& du) {
  NewtonMatrix<dim> matrix{
      .K = K_, .linear = linear_, .is_usable = prepare_matrix(state_n, dt, with_inertia)};
  if (!matrix.is_usable) held_tangent_.reset();
  equilibrium_.set_history(state_n.history);
  equilibrium_.begin_step(state_n.motion, f_ext, start_forces(state_n, with_inertia), dt,
                          with_inertia);
  try {
    const NewtonSettings& newton = with_inertia ? newton_ : static_newton_;
    const NewtonReport report = solve_newton<dim>(equilibrium_, matrix, newton, du, times_);
    if (!matrix.is_usable) held_tangent_.reset();
    if (matrix.is_usable && report.matrices > 0) held_tangent_ = equilibrium_.last_tangent();
    newton_iterations_ += report.iterations;
    return report;
  } catch (const ConvergenceError&) {
    held_tangent_.reset();
    throw;
  }
}

template <int dim>
int StructureStep<dim>::approach(const StructureState& state_n, std::span<const double> f_ext,
                                 double dt, bool with_inertia, std::vector<double>& du) {
  if (!beams_) return 0;
  prepare_matrix(state_n, dt, with_inertia);
  held_tangent_.reset();
  equilibrium_.set_history(state_n.history);
  equilibrium_.begin_step(state_n.motion, f_ext, start_forces(state_n, with_inertia), dt,
                          with_inertia);
  const int steps = take_full_steps(equilibrium_, K_, linear_, du);
  newton_iterations_ += steps;
  return steps;
}

/// Solve from the guess; where that fails, from the displacement at the start of the step. After an
/// impact single nodes may be so fast that they cannot go on at their speed for a step.
template <int dim>
NewtonReport StructureStep<dim>::solve_from_guess(const StructureState& state_n,
                                                  std::span<const double> f_ext, double dt,
                                                  std::vector<double>& du) {
  int full_steps = 0;
  if (!dynamic_ && !last_) full_steps += approach(state_n, f_ext, dt, dynamic_, du);
  const auto solve = [&] {
    NewtonReport report = solve_balance(state_n, f_ext, dt, dynamic_, du);
    report.iterations += full_steps;
    return report;
  };
  try {
    return solve();
  } catch (const ConvergenceError&) {
    if (!dynamic_ && !last_) throw;
  }
  last_.reset();
  du = first_guess(state_n, dt, /*moving=*/false);
  full_steps += approach(state_n, f_ext, dt, dynamic_, du);
  return solve();
}

template <int dim>
void StructureStep<dim>::fill_trial(const StructureState& state_n, ExternalForces f, double dt,
                                    std::span<const double> du, StructureState& trial) {
  // The line search may have evaluated other states after this one.
  std::vector<double> r(equilibrium_.num_dofs());
  equilibrium_.evaluate(du, r, nullptr);
  const NodalForces& forces = equilibrium_.forces();
  trial.time = state_n.time + dt;
  trial.motion = equilibrium_.motion_after(du);
  trial.balanced = true;
  trial.elastic_energy = forces.elastic_energy;
  equilibrium_.find_history(trial, &state_n);
  trial.f_int = forces.internal;
  trial.reactions.assign(f.end.size(), 0.0);
  const bool with_inertia = dynamic_ && dt > 0;
  const std::vector<double> f_start = start_forces(state_n, with_inertia);
  const double memory = with_inertia ? equilibrium_.scheme().force_memory() : 0;
  for (const auto dof : conditions_.constrained_dofs()) {
    const double missing = forces.internal[dof] + forces.inertia[dof] - f.end[dof] - f.step[dof];
    trial.reactions[dof] = memory == 0 ? missing : (missing - memory * f_start[dof]) / (1 + memory);
  }
  trial.f_ext = std::move(f.end);
  trial.f_step = std::move(f.step);
  trial.external_work =
      state_n.external_work + work_of_loads(equilibrium_, conditions_, state_n, trial, du);
  trial.tangent = held_tangent_;
  trial.rescue = linear_.rescue();
  trial.pause = linear_.pause();
}

/// The vector that the corrections (T9) use for M^-1 f. @param trial  of the step of dt
template <int dim>
std::vector<double> StructureStep<dim>::kick_of(const std::vector<double>& f, double dt,
                                                const StructureState& trial) {
  const NewmarkBossak& scheme = equilibrium_.scheme();
  if (!step_force_is_implicit(scheme)) return equilibrium_.acceleration_of(f);
  if (!held_tangent_ || held_tangent_->dt != dt || !held_tangent_->with_inertia) {
    equilibrium_.assemble_tangent(trial.motion.u, dt, /*with_inertia=*/true, K_);
    linear_.set_matrix(K_, shared());
    held_tangent_ = equilibrium_.last_tangent();
  }
  std::vector<double> r = f, a(f.size(), 0.0);
  for (const auto dof : conditions_.constrained_dofs()) r[dof] = 0;
  linear_.solve(r, a);
  for (double& x : a) x *= scheme.inertia_slope(dt);
  for (const auto dof : conditions_.constrained_dofs()) a[dof] = 0;
  return a;
}

template <int dim>
void StructureStep<dim>::complete(const StructureState& state_n, double dt, StructureState& trial) {
  if (dynamic_ && !shared().all(trial.f_step == state_n.f_step)) {
    const ScopedTimer timer(times_, "step_forces");
    const NewmarkBossak& scheme = equilibrium_.scheme();
    std::vector<double> change = trial.f_step;
    for (std::size_t i = 0; i < change.size(); ++i) change[i] -= state_n.f_step[i];
    equilibrium_.set_history(state_n.history);
    const std::vector<double> a = kick_of(change, dt, trial);
    for (std::size_t i = 0; i < a.size(); ++i) {
      trial.motion.v[i] += dt * scheme.step_force_velocity() * a[i];
      trial.motion.a[i] -= scheme.step_force_acceleration() * a[i];
    }
    for (auto* y : {&trial.motion.v, &trial.motion.a}) equilibrium_.embedded().follow(*y);
    // The balance has c times the change of the mean forces, but the supports bear it only once.
    const std::vector<double> inertia = equilibrium_.mass_times(a);
    for (const auto dof : conditions_.constrained_dofs()) {
      trial.reactions[dof] -= (scheme.step_force_weight() - 1) * inertia[dof];
    }
  }
  trial.external_work += work_of_supports(equilibrium_, conditions_, state_n, trial, dynamic_);
  trial.damping_work = equilibrium_.damping_work(state_n, trial, dt);
  if (!dynamic_) stability_.look_at(state_n, trial, equilibrium_);
}

template <int dim>
StepReport StructureStep<dim>::solve(const StructureState& state_n,
                                     const ExternalForces& f_interface, double dt,
                                     StructureState& trial) {
  ExternalForces f = external_forces(state_n.time + dt, f_interface);
  StepReport report;
  report.details = {{"skipped", 0}, {"matrix_assemblies", 0}};
  if (state_n.balanced &&
      nothing_changes(state_n, f, conditions_.displacements(state_n.time + dt))) {
    trial = state_n;
    trial.time = state_n.time + dt;
    ++skipped_solves_;
    report.details["skipped"] = 1;
    return report;
  }
  if (last_ && last_->dt != dt) last_.reset();
  if (last_ && shared().all(last_->f == f)) {
    trial = last_->trial;
    ++repeated_solves_;
    return last_->report;
  }
  std::vector<double> du = last_ ? last_->du : first_guess(state_n, dt);
  try {
    const NewtonReport newton = solve_from_guess(state_n, balanced_forces(state_n, f), dt, du);
    report.newton_iterations = newton.iterations;
    report.linear_iterations = newton.linear_iterations;
    report.details["matrix_assemblies"] = newton.matrices;
  } catch (const ConvergenceError& error) {
    last_.reset();
    explain_failure(state_n, error);
    throw;
  }
  fill_trial(state_n, f, dt, du, trial);
  last_ =
      Iterate{.f = std::move(f), .dt = dt, .du = std::move(du), .trial = trial, .report = report};
  ++solves_;
  return report;
}

template <int dim>
bool StructureStep<dim>::at_rest(const StructureState& state) const {
  return shared().all(state.balanced && state.motion.is_still() &&
                      conditions_.constant_after(state.time));
}

template <int dim>
Json StructureStep<dim>::summary() const {
  Json wall = Json::object();
  for (const auto& [phase, seconds] : times_.seconds()) wall[phase] = seconds;
  return {{"linear_solver", solves_ > 0 ? linear_.method_name() : "none yet"},
          {"solves", solves_},
          {"skipped_solves", skipped_solves_},
          {"repeated_solves", repeated_solves_},
          {"newton_iterations", newton_iterations_},
          {"factorisations", linear_.factorisations()},
          {"restored_matrices", restored_matrices_},
          {"krylov_fallbacks", linear_.fallbacks()},
          {"unstable_equilibria", stability_.unstable_states()},
          {"wall_seconds", wall}};
}

template class StructureStep<2>;
template class StructureStep<3>;

}  // namespace gabion::fem
