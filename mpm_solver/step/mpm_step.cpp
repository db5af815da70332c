// SPDX-License-Identifier: BSD-3-Clause
// How MpmSolver sets up a step and guesses its solution.
#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "common/base/log.hpp"
#include "common/mechanics/norm.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/grid/shared_groups.hpp"
#include "mpm_solver/mpm_solver.hpp"
#include "mpm_solver/small_cuts/light_nodes.hpp"

namespace gabion::mpm {

namespace {

// Up to this elastic Courant number free flight is taken as the guess without a trial.
constexpr double flight_courant = 2;

// Strain that a known stress may be carried over, as a share of Newton's relative tolerance: what
// it can leave out (second order; first order across the yield surface) stays below that tolerance.
constexpr double same_strain_share = 0.01;

// Newmark's method with these parameters asks for no acceleration at the start of a step:
// du = dt v + dt^2 a' / 2, v' = v + dt a'. For a first step whose forces are not those before it.
constexpr NewmarkBossak starting_scheme = {.beta = 0.5, .gamma = 1};

}  // namespace

template <int dim>
std::vector<std::int32_t> MpmSolver<dim>::occupied_cells() const {
  std::vector<std::int32_t> occupied(grid_.mesh.num_cells(), 0);
  for (const std::int32_t cell : points_.cell) occupied[cell] = 1;
  sum_over_ranks(comm_, std::span<std::int32_t>(occupied));
  return occupied;
}

// Nodal forces of the body acceleration at a time, empty when there is none.
template <int dim>
std::vector<double> MpmSolver<dim>::body_forces(double time) const {
  if (!settings_.body_acceleration) return {};
  std::vector<Vector<dim>> b;
  for (std::int32_t p = 0; p < points_.size(); ++p) {
    b.push_back(settings_.body_acceleration(points_.x[p] - points_.u[p], time));
  }
  return point_forces<dim>(comm_, points_, weights_, nodes_, b);
}

template <int dim>
void MpmSolver<dim>::cure_small_cuts() {
  const SmallCutSettings& cuts = settings_.small_cuts;
  const SmallCutMethod method = method_in(cuts, grid_.basis, phase().dynamic);
  if (!with_inertia_ || method == SmallCutMethod::mass_cutoff) {
    const auto joined =
        join_light_nodes(comm_, grid_, points_, weights_, walls(), cuts.mass_share, nodes_);
    if (joined > 0) points_to_grid(comm_, points_, weights_, nodes_);
    joined_nodes_ += joined;
  }
  ghost_acts_ = method == SmallCutMethod::ghost;
  if (!ghost_acts_) return;
  ghost_->begin_step(comm_, grid_, points_, weights_, nodes_);
  ghost_acts_ = ghost_->num_facets() > 0;
  ghost_steps_ += ghost_acts_;
  ghost_facets_ += ghost_->num_facets();
}

template <int dim>
void MpmSolver<dim>::map_to_nodes() {
  {
    const ScopedTimer timer(times_, "search");
    evaluate_basis(grid_, points_, weights_);
    if (settings_.locking.average_volumes) {
      share_groups(comm_, grid_.mesh.num_cells(), weights_);
    }
    activate_nodes(comm_, grid_, weights_, nodes_);
  }
  {
    const ScopedTimer timer(times_, "points to grid");
    points_to_grid(comm_, points_, weights_, nodes_);
    cure_small_cuts();
    walls().select(nodes_);
  }
}

template <int dim>
LinearRegime MpmSolver<dim>::regime() const {
  bool symmetric = true;
  for (const auto& body : settings_.bodies) {
    symmetric &=
        std::visit([](const auto& law) { return law.symmetric_tangent(); }, body.material.law);
  }
  for (const auto& boundary : boundaries_) {
    symmetric &= !(boundary.can_touch() && boundary.has_friction());
  }
  const double courant = wave_speed_ * dt_ / cell_size_;
  return {symmetric, with_inertia_ ? courant : std::numeric_limits<double>::infinity()};
}

// Which phase it is, and how its step goes.
template <int dim>
void MpmSolver<dim>::enter_phase(double time) {
  const std::size_t before = phase_;
  phase_ = phase_at(settings_.phases, time);
  if (phase_ != before) {
    log::info("{:.6g} s: phase {} of {}, {}, {} walls", time, phase_ + 1, settings_.phases.size(),
              phase().dynamic ? "dynamic" : "quasi-static", phase().walls.size());
  }
  const bool stressed =
      std::any_of(settings_.initial_stress.begin(), settings_.initial_stress.end(),
                  [](const auto& stress) { return stress.has_value(); });
  with_inertia_ = phase().dynamic;
  scheme_ = begins(phase(), time) && (phase_ > 0 || stressed) ? starting_scheme : phase().scheme;
}

template <int dim>
void MpmSolver<dim>::begin_step(const StepRequest& request) {
  enter_phase(request.time);
  require_within(phase(), request.time, request.dt);
  walls().begin_step(request.time, request.dt);
  dt_ = request.dt;
  map_to_nodes();
  f_body_ = body_forces(request.time + request.dt);
  f_body_start_.clear();
  if (scheme_.force_memory() != 0) f_body_start_ = body_forces(request.time);
  const LoadRamp& ramp = phase().gravity_ramp;
  make_equilibrium(ramp.at(request.time), ramp.at(request.time + request.dt), request.dt);
}

template <int dim>
void MpmSolver<dim>::make_equilibrium(double load_factor_n, double load_factor, double dt) {
  const ScopedTimer timer(times_, "pattern");
  if (!boundaries_.empty()) {
    const auto occupied = occupied_cells();
    for (auto& boundary : boundaries_) boundary.begin_step(grid_, nodes_, occupied, soil_reach_);
  }
  equilibrium_.emplace(
      typename Equilibrium<dim>::Parts{comm_,
                                       grid_,
                                       settings_.bodies,
                                       points_,
                                       weights_,
                                       nodes_,
                                       walls(),
                                       boundaries_,
                                       trial_,
                                       scheme_,
                                       load_factor * settings_.gravity,
                                       load_factor_n * settings_.gravity,
                                       cell_size_,
                                       same_strain_share * settings_.newton.residual_tolerance,
                                       dt,
                                       with_inertia_,
                                       f_body_,
                                       f_body_start_,
                                       settings_.locking.average_volumes,
                                       ghost_acts_ ? &*ghost_ : nullptr});
  std::vector<std::int32_t> offsets, cell_nodes;
  equilibrium_->pattern(offsets, cell_nodes);
  K_.set_pattern(nodes_.size(), offsets, cell_nodes);
  linear_.set_regime(regime(), nodes_.size());
}

template <int dim>
std::vector<Vector<dim>> MpmSolver<dim>::forces_on_walls() const {
  std::vector<Vector<dim>> sums(wall_groups_.size(), Vector<dim>::Zero());
  const auto forces = equilibrium_->wall_forces();
  for (std::size_t w = 0; w < forces.size(); ++w) {
    const auto& group = phase().walls[w].group;
    const auto place = std::find(wall_groups_.begin(), wall_groups_.end(), group);
    sums[static_cast<std::size_t>(place - wall_groups_.begin())] += forces[w];
  }
  return sums;
}

template <int dim>
std::vector<double> MpmSolver<dim>::forces_on_rigid_walls() const {
  std::vector<double> values;
  for (std::size_t k = settings_.interfaces.size(); k < boundaries_.size(); ++k) {
    const auto [force, moment] = boundaries_[k].resultant();
    values.insert(values.end(), force.data(), force.data() + force.size());
    values.insert(values.end(), moment.data(), moment.data() + moment.size());
  }
  sum_over_ranks(comm_, std::span<double>(values));  // the first rank has the contact
  return values;
}

// du holds the displacement of the walls: add that of the soil by the stiffness at the start.
template <int dim>
void MpmSolver<dim>::spread_wall_step() {
  const ScopedTimer timer(times_, "guess");
  std::vector<double> r(du_.size()), step(du_.size());
  if (!equilibrium_->linearise(du_, r, K_).admissible) return;  // Newton's method says why
  linear_.set_matrix(K_);
  linear_iterations_ += linear_.solve(r, step);
  for (std::size_t k = 0; k < du_.size(); ++k) du_[k] += step[k];
}

// Start Newton from free flight, quasi-static from rest but for the walls. Where elastic waves
// cross many cells in a step, flight and rest are tried and the smaller residual wins: there the
// guess matters more than its cost.
template <int dim>
void MpmSolver<dim>::choose_guess() {
  const auto& v = equilibrium_->start_velocity();
  const auto& a = equilibrium_->start_acceleration();
  du_.assign(v.size(), 0.0);
  walls().impose(du_, 1);
  if (!with_inertia_) {
    if (walls().move()) spread_wall_step();
    return;
  }
  std::vector<double> still = du_;
  for (std::size_t k = 0; k < du_.size(); ++k) du_[k] = dt_ * (v[k] + 0.5 * dt_ * a[k]);
  if (wave_speed_ * dt_ <= flight_courant * cell_size_) return;
  const ScopedTimer timer(times_, "guess");
  std::vector<double> r(du_.size());
  const Evaluation flight = equilibrium_->evaluate(du_, r, nullptr);
  const double r_flight = norm_of(r);
  equilibrium_->evaluate(still, r, nullptr);
  if (!flight.admissible || norm_of(r) < r_flight) du_ = std::move(still);
}

template <int dim>
void MpmSolver<dim>::receive(const InterfaceValues& received) {
  for (std::size_t k = 0; k < settings_.interfaces.size(); ++k) {
    auto& boundary = boundaries_[k];
    const auto found = received.find(boundary.name());
    if (found != received.end()) {
      boundary.set_displacement(found->second);
    } else {
      boundary.set_displacement(std::vector<double>(boundary.interface_mesh().coordinates.size()));
    }
  }
}

template <int dim>
void MpmSolver<dim>::move_rigid_walls(double time) {
  for (std::size_t k = 0; k < settings_.rigid_walls.size(); ++k) {
    const auto& wall = settings_.rigid_walls[k];
    boundaries_[settings_.interfaces.size() + k].set_displacement(
        wall.motion.displacement(wall.boundary.surface.vertices, time));
  }
}

template <int dim>
NodalMotion<dim> MpmSolver<dim>::nodal_motion() const {
  const std::size_t n = nodes_.grid_node.size();
  const auto& v = equilibrium_->start_velocity();
  const auto& a = equilibrium_->start_acceleration();
  NodalMotion<dim> motion;
  motion.du.resize(n);
  motion.v_new.assign(n, Vector<dim>::Zero());
  motion.a_new.assign(n, Vector<dim>::Zero());
  for (std::size_t i = 0; i < n; ++i) {
    for (int d = 0; d < dim; ++d) {
      const std::size_t k = i * dim + d;
      motion.du[i][d] = du_[k];
      if (!with_inertia_) continue;
      motion.a_new[i][d] = scheme_.acceleration(du_[k], v[k], a[k], dt_);
      motion.v_new[i][d] = scheme_.velocity(motion.a_new[i][d], v[k], a[k], dt_);
    }
  }
  return motion;
}

template std::vector<std::int32_t> MpmSolver<2>::occupied_cells() const;
template std::vector<std::int32_t> MpmSolver<3>::occupied_cells() const;
template std::vector<double> MpmSolver<2>::body_forces(double time) const;
template std::vector<double> MpmSolver<3>::body_forces(double time) const;
template void MpmSolver<2>::cure_small_cuts();
template void MpmSolver<3>::cure_small_cuts();
template void MpmSolver<2>::map_to_nodes();
template void MpmSolver<3>::map_to_nodes();
template LinearRegime MpmSolver<2>::regime() const;
template LinearRegime MpmSolver<3>::regime() const;
template void MpmSolver<2>::enter_phase(double time);
template void MpmSolver<3>::enter_phase(double time);
template void MpmSolver<2>::begin_step(const StepRequest& request);
template void MpmSolver<3>::begin_step(const StepRequest& request);
template void MpmSolver<2>::make_equilibrium(double load_factor_n, double load_factor, double dt);
template void MpmSolver<3>::make_equilibrium(double load_factor_n, double load_factor, double dt);
template std::vector<Vector<2>> MpmSolver<2>::forces_on_walls() const;
template std::vector<Vector<3>> MpmSolver<3>::forces_on_walls() const;
template std::vector<double> MpmSolver<2>::forces_on_rigid_walls() const;
template std::vector<double> MpmSolver<3>::forces_on_rigid_walls() const;
template void MpmSolver<2>::spread_wall_step();
template void MpmSolver<3>::spread_wall_step();
template void MpmSolver<2>::choose_guess();
template void MpmSolver<3>::choose_guess();
template void MpmSolver<2>::receive(const InterfaceValues& received);
template void MpmSolver<3>::receive(const InterfaceValues& received);
template void MpmSolver<2>::move_rigid_walls(double time);
template void MpmSolver<3>::move_rigid_walls(double time);
template NodalMotion<2> MpmSolver<2>::nodal_motion() const;
template NodalMotion<3> MpmSolver<3>::nodal_motion() const;

}  // namespace gabion::mpm
