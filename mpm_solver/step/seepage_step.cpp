// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step/seepage_step.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "mpm_solver/checks/pools.hpp"

namespace gabion::mpm {

namespace {

// Tolerance of the residual: a step changes the volume of water by much less than the stresses
// could, and a residual that is merely small beside these would let slow seepage stand still.
constexpr double water_tolerance = 1e-9;

// Most solutions of a step, with other places where rain runs off or water leaves; mostly one or
// two suffice.
constexpr int most_changes_of_outlets = 20;

// The matrix is indefinite: no Krylov method with the preconditioners at hand solves it.
LinearSolverSettings direct(LinearSolverSettings settings) {
  settings.preconditioner = "auto";
  if (settings.method != "mumps") settings.method = "lu";
  return settings;
}

}  // namespace

template <int dim>
SeepageStep<dim>::SeepageStep(const Parts& parts)
    : ImplicitStep<dim>(parts),
      borders_(parts.model),
      solver_(parts.model.comm, dim, direct(parts.model.settings.linear_solver)) {}

template <int dim>
StressParts<dim> SeepageStep<dim>::stress_parts() const {
  return {.bodies = this->parts_.model.settings.bodies,
          .points = this->parts_.state.points,
          .weights = this->parts_.soil.weights(),
          .nodes = this->parts_.soil.nodes(),
          .trial = this->parts_.trial,
          .laws = this->parts_.soil.laws().of_points()};
}

template <int dim>
void SeepageStep<dim>::make_water(const StepStart& start, double time, const Vector<dim>& gravity) {
  const auto& model = this->parts_.model;
  pools_ = pool_levels<dim>(model.settings, time, gravity);
  water_.emplace(stress_parts(),
                 SeepageStepData<dim>{
                     .gravity = gravity,
                     .dt = start.dt,
                     .cell_size = model.cell_size,
                     .inertia_slope = start.with_inertia ? start.scheme.inertia_slope(start.dt) : 0,
                     .averages = model.settings.locking.average_volumes,
                     .pools = pools_,
                     .rain = borders_.rain_at(time)});
  this->f_pore_ = water_->forces();
}

template <int dim>
void SeepageStep<dim>::begin(const StepStart& start) {
  const auto& model = this->parts_.model;
  balance_.reset();
  const LoadRamp& ramp = model.settings.phases[start.phase].gravity_ramp;
  const double end = start.time + start.dt;
  const Vector<dim> gravity = ramp.at(end) * model.settings.gravity;
  make_water(start, end, gravity);
  ImplicitStep<dim>::begin(start);
  open_borders(start, gravity);
  begin_matrix();
  balance_.emplace(*this->equilibrium_, *water_, this->system_.K(),
                   drained_nodes(start, end, gravity));
}

// Let water pass the surface of the soil and sides of the grid.
template <int dim>
void SeepageStep<dim>::open_borders(const StepStart& start, const Vector<dim>& gravity) {
  const BackgroundGrid<dim>& grid = this->parts_.model.grid;
  if (borders_.open()) water_->open(grid, borders_.free_surface(this->parts_.state, start.phase));
  const auto sides = borders_.fed_sides(start.phase);
  if (sides.empty()) return;
  water_->feed(
      SeepageInlets<dim>(stress_parts(), grid, sides, {.gravity = gravity, .dt = start.dt}));
}

// The matrix with the pattern of the balance.
template <int dim>
void SeepageStep<dim>::begin_matrix() {
  if (!K_) {
    K_.emplace([this](const BlockMatrix<dim + 1>& K) { return solver_.make_room(K); });
  }
  std::vector<std::int32_t> offsets, cell_nodes;
  this->equilibrium_->pattern(offsets, cell_nodes);
  const auto& nodes = this->parts_.soil.nodes();
  solver_.begin_step({});
  K_->set_pattern(nodes.size(), offsets, cell_nodes);
  solver_.set_regime({.symmetric = false, .courant = std::numeric_limits<double>::infinity()},
                     nodes.num_of_all());
}

template <int dim>
DrainedNodes SeepageStep<dim>::drained_nodes(const StepStart& start, double time,
                                             const Vector<dim>& gravity) const {
  return borders_.drained_nodes(
      this->parts_.soil.nodes(),
      {.phase = start.phase, .time = time, .gravity = gravity, .pools = pools_});
}

// The guess is flight or rest under the pressures of the start, whichever is nearer to balance.
template <int dim>
std::vector<double> SeepageStep<dim>::first_displacement() {
  Equilibrium<dim>& equilibrium = *this->equilibrium_;
  const auto& parts = equilibrium.parts();
  const auto &v = equilibrium.start_velocity(), &a = equilibrium.start_acceleration();
  std::vector<double> still(v.size(), 0.0);
  parts.walls.impose(still, 1);
  if (!parts.with_inertia) return still;
  std::vector<double> du(still), r(v.size() / dim * (dim + 1));
  for (std::size_t k = 0; k < du.size(); ++k) du[k] = parts.dt * (v[k] + 0.5 * parts.dt * a[k]);
  parts.walls.impose(du, 1);
  const auto residual = [&](const std::vector<double>& guess) {
    const Evaluation at_guess = balance_->evaluate(balance_->guess(guess), r, nullptr);
    return at_guess.admissible ? *at_guess.residual_norm : std::numeric_limits<double>::infinity();
  };
  return residual(still) < residual(du) ? still : du;
}

template <int dim>
NewtonReport SeepageStep<dim>::iterate(bool first, const NewtonSettings& settings) {
  if (first) {
    this->equilibrium_->internal_forces().forget();
    x_ = balance_->guess(first_displacement());
  }
  this->equilibrium_->begin_solution();
  NewtonSettings tight = settings;
  tight.residual_tolerance = std::min(settings.residual_tolerance, water_tolerance);
  const std::vector<double> start = x_;
  NewtonReport report;
  try {
    report = solve(tight);
  } catch (const ConvergenceError&) {
    if (!borders_.open()) throw;
    // Newton's method may have failed at the kink of outlets that open; these are now kept during a
    // solution.
    water_->hold_outlets();
    x_ = start;
    report = solve(tight);
  }
  this->du_ = balance_->displacement(x_);
  return report;
}

// Solve with one set of places after the other where rain runs off or water leaves, until the set
// stays.
template <int dim>
NewtonReport SeepageStep<dim>::solve(const NewtonSettings& settings) {
  NewtonMatrix<dim + 1> matrix{*K_, solver_};
  NewtonReport report = solve_newton<dim + 1>(*balance_, matrix, settings, x_, this->parts_.times);
  for (int k = 0; water_->update_outlets(); ++k) {
    if (k == most_changes_of_outlets) {
      throw ConvergenceError(fmt::format(
          "places where rain runs off or water leaves still change after {} solutions", k));
    }
    const int iterations = report.iterations;
    report = solve_newton<dim + 1>(*balance_, matrix, settings, x_, this->parts_.times);
    report.iterations += iterations;
  }
  return report;
}

template <int dim>
StepEnd<dim> SeepageStep<dim>::end() {
  std::vector<double> r(x_.size());
  balance_->evaluate(x_, r, nullptr);
  StepEnd<dim> end = ImplicitStep<dim>::end();
  end.plastic_work += water_->finish(this->du_) + water_->weight_work();
  const SharedNodes& shared = balance_->shared();
  end.balance.body_work += shared.total(water_->weight_work());
  end.balance.boundary_work += shared.total(balance_->drained_work());
  const double fed = shared.total(water_->inflow_work());
  end.plastic_work += water_->inflow_work() + balance_->drained_work();
  if (pools_.empty()) {
    end.balance.boundary_work += fed;
    return end;
  }
  // The trapezoidal rule of the ledger does not apply to pools.
  const double work = shared.total(water_->pool_work(this->du_));
  end.balance.boundary_work += work + fed;
  end.balance.time_damping += 0.5 * work;
  Vector<dim> force = water_->pool_force();
  shared.total({force.data(), dim});
  end.balance.boundary_force += force;
  return end;
}

template <int dim>
void SeepageStep<dim>::finish_points(MaterialPoints<dim>& points) const {
  water_->store(points);
}

template <int dim>
void SeepageStep<dim>::remember(SoilState<dim>& state) const {
  ImplicitStep<dim>::remember(state);
  state.water_out += balance_->outflow();
  state.rain_in += water_->rain_in();
  state.rain_run_off += water_->rain_run_off();
}

template <int dim>
void SeepageStep<dim>::release() {
  balance_.reset();
  this->f_pore_ = {};
  ImplicitStep<dim>::release();
  water_.reset();
  solver_.release();
  K_.reset();
}

template <int dim>
std::vector<double> SeepageStep<dim>::settlement(const StepStart& start, const Vector<dim>& gravity,
                                                 const std::string& where) {
  make_water(start, start.time, gravity);
  water_->find_start_forces();
  return ImplicitStep<dim>::settlement(start, gravity, where);
}

template class SeepageStep<2>;
template class SeepageStep<3>;

}  // namespace gabion::mpm
