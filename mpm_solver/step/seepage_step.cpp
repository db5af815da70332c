// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step/seepage_step.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>

#include "mpm_solver/checks/pools.hpp"
#include "mpm_solver/checks/seepage.hpp"
#include "mpm_solver/contact/start_check.hpp"
#include "mpm_solver/step/free_surface.hpp"

namespace gabion::mpm {

namespace {

// A step changes the volume of water by much less than the stresses could, and a residual that is
// small beside them would let slow seepage stand still.
constexpr double water_tolerance = 1e-9;

// Solutions of a step with other places where rain runs off or water leaves: mostly one or two.
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
      solver_(parts.model.comm, dim, direct(parts.model.settings.linear_solver)) {
  const MpmSettings<dim>& settings = parts.model.settings;
  for (std::size_t b = 0; b < settings.bodies.size(); ++b) {
    if (!drains(settings.bodies[b]) || !settings.bodies[b].water->seepage_face) continue;
    with_seepage_face_.push_back(static_cast<std::int32_t>(b));
  }
  if (with_seepage_face_.empty()) return;
  const auto surfaces = surfaces_at_start(settings.interfaces, settings.rigid_walls);
  if (surfaces.empty()) return;
  sights_.emplace(surfaces, parts.model.grid);
  for (std::size_t k = 0; k < surfaces.size(); ++k) {
    if (surfaces[k].settings.drained) sights_->leave_out(k);
  }
}

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
                     .rain = rain_at(time)});
  this->f_pore_ = water_->forces();
}

template <int dim>
void SeepageStep<dim>::begin(const StepStart& start) {
  const auto& model = this->parts_.model;
  balance_.reset();
  const LoadRamp& ramp = model.settings.phases[start.phase].gravity_ramp;
  const double end = start.time + start.dt;
  make_water(start, end, ramp.at(end) * model.settings.gravity);
  ImplicitStep<dim>::begin(start);
  open_surface();
  Equilibrium<dim>& equilibrium = *this->equilibrium_;
  if (!K_) {
    K_.emplace([this](const BlockMatrix<dim + 1>& K) { return solver_.make_room(K); });
  }
  std::vector<std::int32_t> offsets, cell_nodes;
  equilibrium.pattern(offsets, cell_nodes);
  const auto& nodes = this->parts_.soil.nodes();
  solver_.begin_step({});
  K_->set_pattern(nodes.size(), offsets, cell_nodes);
  solver_.set_regime({.symmetric = false, .courant = std::numeric_limits<double>::infinity()},
                     nodes.num_of_all());
  balance_.emplace(equilibrium, *water_, this->system_.K(), drained_nodes());
}

template <int dim>
void SeepageStep<dim>::open_surface() {
  if (with_seepage_face_.empty()) return;
  const auto& model = this->parts_.model;
  const bool meets_surfaces = sights_ && sights_->follow(this->parts_.state.surfaces);
  const SurroundingsOfSoil<dim> surroundings{
      .comm = model.comm,
      .grid = model.grid,
      .points = this->parts_.state.points,
      .walls = model.settings.phases[this->start_.phase].walls,
      .surfaces = meets_surfaces ? &*sights_ : nullptr};
  const auto surface = find_free_surface<dim>(surroundings, with_seepage_face_);
  water_->open(model.grid, surface);
}

template <int dim>
Vector<dim> SeepageStep<dim>::rain_at(double time) const {
  const MpmSettings<dim>& settings = this->parts_.model.settings;
  if (!settings.rain) return Vector<dim>::Zero();
  return settings.rain->at(time) * settings.gravity.normalized();
}

// The water beyond the walls is at rest, below the level of pools, or else the table of the soil.
template <int dim>
DrainedNodes SeepageStep<dim>::drained_nodes() const {
  const auto& model = this->parts_.model;
  const auto& nodes = this->parts_.soil.nodes();
  const auto& bodies = model.settings.bodies;
  auto soil = std::ranges::find_if(
      bodies, [&](const Body<dim>& body) { return drains(body) && body.water->table; });
  if (soil == bodies.end()) soil = std::ranges::find_if(bodies, drains<dim>);
  const Phase& phase = model.settings.phases[this->start_.phase];
  const double share = phase.gravity_ramp.at(this->start_.time + this->start_.dt);
  std::map<std::int32_t, double> q;
  const auto drain = [&](std::int32_t node) {
    const std::int32_t i = nodes.active[node];
    if (i < 0) return;
    const Vector<dim>& x = nodes.x[i];
    const double beyond =
        pools_.empty() ? share * soil->water->hydrostatic(x[dim - 1]) : pools_.pressure<dim>(x);
    q[i] = beyond - water_->at_rest(static_cast<std::int32_t>(soil - bodies.begin()), x);
  };
  for (const WallSettings& wall : phase.walls) {
    if (!wall.drained) continue;
    for (const std::int32_t node :
         find_group_nodes(model.grid.facet_groups, wall.group, wall.where)) {
      for (std::int32_t f = 0; f < nodes.num_fields; ++f) drain(node + f * nodes.num_places);
    }
  }
  DrainedNodes drained;
  for (const auto& [node, value] : q) {
    drained.nodes.push_back(node);
    drained.q.push_back(value);
  }
  return drained;
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
    if (with_seepage_face_.empty()) throw;
    // Newton's method may have crept over the kink of outlets that open.
    water_->hold_outlets();
    x_ = start;
    report = solve(tight);
  }
  this->du_ = balance_->displacement(x_);
  return report;
}

// With one set of places after the other where rain runs off or water leaves, until it stays.
template <int dim>
NewtonReport SeepageStep<dim>::solve(const NewtonSettings& settings) {
  NewtonMatrix<dim + 1> matrix{*K_, solver_};
  NewtonReport report = solve_newton<dim + 1>(*balance_, matrix, settings, x_, this->parts_.times);
  for (int k = 0; water_->update_outlets(); ++k) {
    if (k == most_changes_of_outlets) {
      throw ConvergenceError(
          fmt::format("places where rain runs off or water leaves change after {} solutions", k));
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
  if (pools_.empty()) return end;
  // Pools are no part of what the trapezoidal rule of the ledger is for.
  const double work = shared.total(water_->pool_work(this->du_));
  end.balance.boundary_work += work + shared.total(water_->inflow_work());
  end.balance.time_damping += 0.5 * work;
  end.plastic_work += water_->inflow_work();
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
