// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/mpm_solver.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/log.hpp"
#include "common/mechanics/norm.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/light_nodes.hpp"
#include "mpm_solver/point_domains.hpp"

namespace gabion::mpm {

namespace {

// Up to this elastic Courant number free flight is taken as the guess without a trial.
constexpr double flight_courant = 2;

// Strain that a known stress may be carried over, as a share of Newton's relative tolerance: what
// it can leave out (second order; first order across the yield surface) stays below that tolerance.
constexpr double same_strain_share = 0.01;

// Components of force and moment.
template <int dim>
constexpr std::size_t wall_values = dim == 2 ? 3 : 6;

template <int dim>
MaterialPoints<dim> lay_all_points(MPI_Comm comm, MpmSettings<dim>& settings) {
  MaterialPoints<dim> points;
  std::int64_t total = 0;
  for (std::size_t b = 0; b < settings.bodies.size(); ++b) {
    total += lay_points<dim>(settings.layouts[b], settings.bodies[b].material.density, total,
                             rank_of(comm), num_ranks(comm), points);
  }
  settings.layouts.clear();
  if (settings.tpic) add_gradients(points);
  // Free of stress, so gravity is the acceleration at the start; the walls take their part of it.
  if (settings.dynamic) std::fill(points.a.begin(), points.a.end(), settings.gravity);
  log::info("{} material points in {} {}", total, settings.bodies.size(),
            settings.bodies.size() == 1 ? "body" : "bodies");
  return points;
}

}  // namespace

template <int dim>
MpmSolver<dim>::MpmSolver(MPI_Comm comm, MpmSettings<dim> settings,
                          const std::string& output_folder)
    : comm_(comm),
      settings_(std::move(settings)),
      grid_(std::move(settings_.grid), settings_.basis),
      walls_(grid_.mesh, settings_.walls),
      cell_size_(mean_cell_size(grid_.mesh)),
      points_(lay_all_points(comm, settings_)),
      linear_(comm, settings_.linear_solver),
      output_(comm, output_folder),
      ledger_(comm) {
  for (const auto& body : settings_.bodies) {
    const double modulus =
        std::visit([](const auto& law) { return law.p_wave_modulus(); }, body.material.law);
    wave_speed_ = std::max(wave_speed_, std::sqrt(modulus / body.material.density));
  }
  for (const auto& boundary : settings_.interfaces) boundaries_.emplace_back(boundary);
  for (const auto& wall : settings_.rigid_walls) boundaries_.emplace_back(wall.boundary);
  wall_forces_.assign(settings_.rigid_walls.size() * wall_values<dim>, 0.0);
  if (settings_.small_cuts.method == SmallCutMethod::ghost) {
    ghost_.emplace(grid_.mesh, settings_.bodies, settings_.small_cuts.ghost_factor);
  }
  find_probe_points();
  locate_points(grid_, points_);
  ledger_.start(points_);
  evaluate_basis(grid_, points_, weights_);
  log_grid();
}

template <int dim>
void MpmSolver<dim>::log_grid() const {
  log::info(
      "background grid: {} cells, {} nodes, mean size {:.4g} m; elastic wave speed {:.4g} m/s",
      grid_.mesh.num_cells(), grid_.mesh.num_nodes_total(), cell_size_, wave_speed_);
  std::vector<double> counts = {static_cast<double>(points_.size()),
                                static_cast<double>(weights_.N.size())};
  sum_over_ranks(comm_, std::span<double>(counts));
  log::info("basis: {}, {:.3g} nodes a point", basis_name(grid_.basis), counts[1] / counts[0]);
}

template <int dim>
void MpmSolver<dim>::find_probe_points() {
  for (const auto& probe : settings_.probes) {
    std::int32_t nearest = -1;
    double distance = std::numeric_limits<double>::infinity();
    for (std::int32_t p = 0; p < points_.size(); ++p) {
      const double d = (points_.x[p] - probe.point).norm();
      if (d < distance) {
        distance = d;
        nearest = p;
      }
    }
    const double least = -max_over_ranks(comm_, -distance);
    const double id = distance == least ? static_cast<double>(points_.id[nearest])
                                        : std::numeric_limits<double>::infinity();
    const bool owner = nearest >= 0 && id == -max_over_ranks(comm_, -id);
    probe_points_.push_back(owner ? nearest : -1);
  }
}

template <int dim>
std::vector<InterfaceMesh> MpmSolver<dim>::interfaces() const {
  std::vector<InterfaceMesh> meshes;
  for (std::size_t k = 0; k < settings_.interfaces.size(); ++k) {
    meshes.push_back(boundaries_[k].interface_mesh());
  }
  return meshes;
}

template <int dim>
std::vector<std::int32_t> MpmSolver<dim>::occupied_cells() const {
  std::vector<std::int32_t> occupied(grid_.mesh.num_cells(), 0);
  for (const CellGroup& group : weights_.groups) occupied[group.cell] = 1;
  sum_over_ranks(comm_, std::span<std::int32_t>(occupied));
  return occupied;
}

template <int dim>
void MpmSolver<dim>::cure_small_cuts() {
  if (settings_.small_cuts.mass_share > 0) {
    const auto joined = join_light_nodes(comm_, grid_, points_, weights_, walls_,
                                         settings_.small_cuts.mass_share, nodes_);
    if (joined > 0) points_to_grid(comm_, points_, weights_, nodes_);
    joined_nodes_ += joined;
  }
  if (!ghost_) return;
  ghost_->begin_step(comm_, grid_, points_, weights_, nodes_);
  ghost_steps_ += ghost_->num_facets() > 0;
  ghost_facets_ += ghost_->num_facets();
}

template <int dim>
void MpmSolver<dim>::set_motion(std::vector<Vector<dim>> v, std::vector<Vector<dim>> a) {
  require(v.size() == points_.v.size() && a.size() == points_.a.size(),
          fmt::format("mpm_solver: found {} velocities and {} accelerations for {} points",
                      v.size(), a.size(), points_.size()));
  points_.v = std::move(v);
  points_.a = std::move(a);
  ledger_.start(points_);
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
void MpmSolver<dim>::map_to_nodes() {
  {
    const ScopedTimer timer(times_, "search");
    evaluate_basis(grid_, points_, weights_);
    activate_nodes(comm_, grid_, weights_, nodes_);
  }
  {
    const ScopedTimer timer(times_, "points to grid");
    points_to_grid(comm_, points_, weights_, nodes_);
    cure_small_cuts();
    walls_.select(nodes_);
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
  return {symmetric, settings_.dynamic ? courant : std::numeric_limits<double>::infinity()};
}

template <int dim>
void MpmSolver<dim>::begin_step(double time, double dt) {
  dt_ = dt;
  map_to_nodes();
  f_body_ = body_forces(time + dt);
  f_body_start_.clear();
  if (settings_.scheme.force_memory() != 0) f_body_start_ = body_forces(time);
  const ScopedTimer timer(times_, "pattern");
  if (!boundaries_.empty()) {
    const auto occupied = occupied_cells();
    for (auto& boundary : boundaries_) boundary.begin_step(grid_, nodes_, occupied);
  }
  equilibrium_.emplace(typename Equilibrium<dim>::Parts{
      comm_, grid_, settings_.bodies, points_, weights_, nodes_, walls_, boundaries_, trial_,
      settings_.scheme, settings_.gravity, cell_size_,
      same_strain_share * settings_.newton.residual_tolerance, dt, settings_.dynamic, f_body_,
      f_body_start_, ghost_ && ghost_->num_facets() > 0 ? &*ghost_ : nullptr});
  std::vector<std::int32_t> offsets, cell_nodes;
  equilibrium_->pattern(offsets, cell_nodes);
  K_.set_pattern(nodes_.size(), offsets, cell_nodes);
  new_pattern_ = true;
  linear_.set_regime(regime(), nodes_.size());
}

// Start Newton from free flight, quasi-static from rest. Where elastic waves cross many cells in a
// step, flight and rest are tried and the smaller residual wins: there the guess matters more than
// its cost.
template <int dim>
void MpmSolver<dim>::choose_guess() {
  const auto& v = equilibrium_->start_velocity();
  const auto& a = equilibrium_->start_acceleration();
  du_.assign(v.size(), 0.0);
  if (!settings_.dynamic) return;
  for (std::size_t k = 0; k < du_.size(); ++k) du_[k] = dt_ * (v[k] + 0.5 * dt_ * a[k]);
  if (wave_speed_ * dt_ <= flight_courant * cell_size_) return;
  const ScopedTimer timer(times_, "guess");
  std::vector<double> r(du_.size()), still(du_.size(), 0.0);
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
StepReport MpmSolver<dim>::solve_step(const StepRequest& request, const InterfaceValues& received,
                                      InterfaceValues& sent) {
  const bool begins = dt_ != request.dt;
  if (begins) begin_step(request.time, request.dt);
  receive(received);
  move_rigid_walls(request.time + request.dt);
  if (begins || request.iteration == 0) {
    equilibrium_->internal_forces().forget();
    choose_guess();
  }
  equilibrium_->internal_forces().begin_solution();
  const NewtonReport newton = solve_newton(*equilibrium_, K_, new_pattern_, linear_,
                                           settings_.newton, std::span<double>(du_), times_);
  new_pattern_ = false;
  newton_iterations_ += newton.iterations;
  linear_iterations_ += newton.linear_iterations;
  ++solutions_;
  log::debug("step {} iteration {}: |r|/scale {:.1e}, {} linear iterations", request.step,
             request.iteration, fmt::join(newton.residuals, " "), newton.linear_iterations);

  StepReport report;
  report.newton_iterations = newton.iterations;
  report.linear_iterations = newton.linear_iterations;
  report_contact(report, sent);
  return report;
}

template <int dim>
void MpmSolver<dim>::report_contact(StepReport& report, InterfaceValues& sent) const {
  report.interface_active = false;
  int closed = 0, sliding = 0;
  double penetration = 0;
  const std::size_t num_interfaces = settings_.interfaces.size();
  for (std::size_t k = 0; k < num_interfaces; ++k) {
    const auto& boundary = boundaries_[k];
    sent[boundary.name()] = boundary.forces_on_structure();
    report.interface_active |= boundary.can_touch();
    closed += boundary.num_closed();
    sliding += boundary.num_sliding();
    penetration = std::max(penetration, boundary.max_penetration());
  }
  if (num_interfaces > 0) {
    report.details = {
        {"closed_points", closed}, {"sliding_points", sliding}, {"max_penetration", penetration}};
  }
  for (std::size_t k = num_interfaces; k < boundaries_.size(); ++k) {
    const auto& wall = boundaries_[k];
    report.details[wall.name() + ".closed_points"] = wall.num_closed();
    report.details[wall.name() + ".sliding_points"] = wall.num_sliding();
    report.details[wall.name() + ".max_penetration"] = wall.max_penetration();
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
      if (!settings_.dynamic) continue;
      motion.a_new[i][d] = settings_.scheme.acceleration(du_[k], v[k], a[k], dt_);
      motion.v_new[i][d] = settings_.scheme.velocity(motion.a_new[i][d], v[k], a[k], dt_);
    }
  }
  return motion;
}

template <int dim>
AcceptReport MpmSolver<dim>::accept_step(const StepRequest& request, bool solved) {
  require(solved && dt_ == request.dt, "mpm_solver: a step was accepted that was not solved");
  const ScopedTimer timer(times_, "grid to points");
  equilibrium_->internal_forces().finish(du_);
  const NodalMotion<dim> motion = nodal_motion();
  const StepBalance<dim> balance =
      step_balance(*equilibrium_, std::span<const double>(du_), motion);
  deform_points<dim>(nodes_, du_, weights_, points_);
  capped_domains_ += weights_.num_capped;
  grid_to_points(nodes_, motion, weights_, settings_.pic_share, points_);
  if (!settings_.dynamic) {
    std::fill(points_.v.begin(), points_.v.end(), Vector<dim>::Zero());
    std::fill(points_.a.begin(), points_.a.end(), Vector<dim>::Zero());
  }
  double dissipated = 0;
  for (std::int32_t e = 0; e < points_.size(); ++e) {
    const std::int32_t p = weights_.point[e];
    points_.history[p] = trial_.history[e];
    points_.tau[p] = trial_.tau[e];
    points_.energy[p] = trial_.energy[e];
    points_.J[p] *= trial_.J_ratio[e];
    dissipated += points_.V0[p] * trial_.dissipation[e];
  }
  wall_forces_.clear();
  for (std::size_t k = settings_.interfaces.size(); k < boundaries_.size(); ++k) {
    const auto [force, moment] = boundaries_[k].resultant();
    wall_forces_.insert(wall_forces_.end(), force.data(), force.data() + force.size());
    wall_forces_.insert(wall_forces_.end(), moment.data(), moment.data() + moment.size());
  }
  sum_over_ranks(comm_, std::span<double>(wall_forces_));  // the first rank has the contact
  ledger_.add_step(balance, settings_.scheme, dt_, dissipated, points_);
  for (auto& boundary : boundaries_) boundary.accept();
  const std::vector<std::int32_t> cell_n = points_.cell;
  locate_points(grid_, points_);
  dt_ = 0;
  AcceptReport report;
  report.probes = probes();
  report.details = accepted_details(cell_n);
  return report;
}

template <int dim>
Json MpmSolver<dim>::accepted_details(std::span<const std::int32_t> cell_n) const {
  double smallest = std::numeric_limits<double>::infinity();
  for (const double J_ratio : trial_.J_ratio) smallest = std::min(smallest, J_ratio);
  std::int32_t moved = 0;
  for (std::size_t p = 0; p < cell_n.size(); ++p) moved += points_.cell[p] != cell_n[p];
  sum_over_ranks(comm_, std::span<std::int32_t>(&moved, 1));
  return {{"min_J_ratio", -max_over_ranks(comm_, -smallest)},
          {"active_nodes", nodes_.size()},
          {"points_changed_cell", moved}};
}

template <int dim>
void MpmSolver<dim>::reject_step() {
  dt_ = 0;
}

template <int dim>
void MpmSolver<dim>::write_output(double time) {
  const ScopedTimer timer(times_, "output");
  output_.write(time, points_);
}

template <int dim>
std::vector<std::string> MpmSolver<dim>::probe_names() const {
  static constexpr const char* axes[] = {"x", "y", "z"};
  std::vector<std::string> names = {"mass", "kinetic_energy", "elastic_energy"};
  for (int d = 0; d < dim; ++d) names.push_back(fmt::format("momentum_{}", axes[d]));
  for (const auto& body : settings_.bodies) {
    names.push_back(settings_.bodies.size() == 1 ? "front" : "front_" + body.name);
  }
  for (const auto& name : Ledger<dim>::names()) names.push_back(name);
  for (const auto& probe : settings_.probes) {
    for (int d = 0; d < dim; ++d) names.push_back(fmt::format("{}.u{}", probe.name, axes[d]));
  }
  for (const auto& wall : settings_.rigid_walls) {
    for (int d = 0; d < dim; ++d) names.push_back(fmt::format("{}.f{}", wall.name, axes[d]));
    for (int d = dim == 2 ? 2 : 0; d < 3; ++d) {
      names.push_back(fmt::format("{}.m{}", wall.name, axes[d]));
    }
  }
  return names;
}

template <int dim>
std::vector<double> MpmSolver<dim>::probes() const {
  const PointTotals<dim>& totals = ledger_.totals();
  std::vector<double> values = {totals.mass, totals.kinetic_energy, totals.elastic_energy};
  values.insert(values.end(), totals.momentum.data(), totals.momentum.data() + dim);
  values.insert(values.end(), totals.front.begin(), totals.front.end());
  const auto balance = ledger_.values();
  values.insert(values.end(), balance.begin(), balance.end());
  std::vector<double> motion;
  for (const std::int32_t p : probe_points_) {
    for (int d = 0; d < dim; ++d) motion.push_back(p < 0 ? 0.0 : points_.u[p][d]);
  }
  sum_over_ranks(comm_, std::span<double>(motion));
  values.insert(values.end(), motion.begin(), motion.end());
  values.insert(values.end(), wall_forces_.begin(), wall_forces_.end());
  return values;
}

template <int dim>
Json MpmSolver<dim>::summary() const {
  static constexpr const char* methods[] = {"none", "ghost", "mass_cutoff"};
  const SmallCutMethod method = settings_.small_cuts.method;
  Json cuts = {{"method", methods[static_cast<int>(method)]}};
  if (method == SmallCutMethod::ghost) {
    cuts["steps_with_ghost"] = ghost_steps_;
    cuts["facets"] = ghost_facets_;
  }
  std::vector<double> capped = {static_cast<double>(capped_domains_)};
  sum_over_ranks(comm_, std::span<double>(capped));
  return {{"basis", basis_name(grid_.basis)},
          {"capped_domains", static_cast<std::int64_t>(capped[0])},
          {"analysis", settings_.dynamic ? "dynamic" : "quasi_static"},
          {"joined_nodes", joined_nodes_},
          {"linear_solver", linear_.method_name()},
          {"factorisations", linear_.factorisations()},
          {"linear_fallbacks", linear_.fallbacks()},
          {"solutions", solutions_},
          {"newton_iterations", newton_iterations_},
          {"linear_iterations", linear_iterations_},
          {"small_cuts", cuts},
          {"wall_seconds", times_.seconds()}};
}

template class MpmSolver<2>;
template class MpmSolver<3>;

}  // namespace gabion::mpm
