// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/mpm_solver.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "common/mechanics/norm.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "common/mechanics/ranks/text.hpp"
#include "common/mechanics/tensor_functions.hpp"
#include "mpm_solver/grid/point_domains.hpp"
#include "mpm_solver/grid/shared_groups.hpp"
#include "mpm_solver/small_cuts/light_nodes.hpp"

namespace gabion::mpm {

namespace {

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
  const Phase& phase = settings.phases.front();
  const Vector<dim> gravity = phase.gravity_ramp.at(0) * settings.gravity;
  // Free of stress, so gravity is the acceleration at the start; the walls take their part of it.
  if (phase.dynamic) std::fill(points.a.begin(), points.a.end(), gravity);
  for (std::size_t b = 0; b < settings.bodies.size(); ++b) {
    if (!settings.initial_stress[b]) continue;
    set_initial_stress<dim>(comm, *settings.initial_stress[b], settings.bodies[b],
                            static_cast<std::int32_t>(b), gravity, points);
  }
  log::info("{} material points in {} {}", total, settings.bodies.size(),
            settings.bodies.size() == 1 ? "body" : "bodies");
  return points;
}

// Over all ranks [m].
template <int dim>
double mean_point_size(MPI_Comm comm, const MaterialPoints<dim>& points) {
  double sums[] = {0, static_cast<double>(points.size())};
  for (const double volume : points.V0) sums[0] += volume;
  sum_over_ranks(comm, std::span<double>(sums));
  return std::pow(sums[0] / sums[1], 1.0 / dim);
}

}  // namespace

template <int dim>
MpmSolver<dim>::MpmSolver(MPI_Comm comm, MpmSettings<dim> settings,
                          const std::string& output_folder)
    : comm_(comm),
      settings_(std::move(settings)),
      grid_(std::move(settings_.grid), settings_.basis),
      cell_size_(mean_cell_size(grid_.mesh)),
      exits_(grid_),
      points_(lay_all_points(comm, settings_)),
      linear_(comm, dim, settings_.linear_solver),
      output_(comm, output_folder),
      ledger_(comm),
      control_(settings_.step_control) {
  for (const Phase& phase : settings_.phases) {
    walls_of_phases_.emplace_back(grid_.mesh, phase.walls);
    for (const auto& wall : phase.walls) {
      const auto known = std::find(wall_groups_.begin(), wall_groups_.end(), wall.group);
      if (known == wall_groups_.end()) wall_groups_.push_back(wall.group);
    }
  }
  wall_forces_.assign(wall_groups_.size(), Vector<dim>::Zero());
  for (const auto& body : settings_.bodies) {
    const double modulus =
        std::visit([](const auto& law) { return law.p_wave_modulus(); }, body.material.law);
    wave_speed_ = std::max(wave_speed_, std::sqrt(modulus / body.material.density));
  }
  for (const auto& boundary : settings_.interfaces) boundaries_.emplace_back(boundary);
  for (const auto& wall : settings_.rigid_walls) boundaries_.emplace_back(wall.boundary);
  rigid_wall_forces_.assign(settings_.rigid_walls.size() * wall_values<dim>, 0.0);
  if (any_has_method(SmallCutMethod::ghost, settings_.small_cuts, settings_.basis,
                     settings_.phases)) {
    ghost_.emplace(grid_.mesh, settings_.bodies, settings_.small_cuts.ghost_factor);
  }
  if (!boundaries_.empty()) soil_reach_ = 0.5 * mean_point_size(comm_, points_);
  find_probe_points();
  locate_at_start();
  prepare_averages();
  ledger_.start(points_);
  evaluate_basis(grid_, points_, weights_);
  log_grid();
  check_initial_stress();
}

template <int dim>
void MpmSolver<dim>::locate_at_start() {
  const auto outside = find_cells(grid_, points_);
  std::string own;
  if (!outside.empty()) {
    const std::int32_t p = outside.front();
    const auto& starts = points_.body_starts;
    const auto next = std::upper_bound(starts.begin(), starts.end(), p);
    const Vector<dim>& x = points_.x[p];
    own = fmt::format(
        "{}/{}: found material point {} at ({}), which lies outside the background grid, allowed: "
        "all of the body inside the grid",
        settings_.bodies_where, next - starts.begin() - 1, points_.id[p],
        fmt::join(x.data(), x.data() + dim, ", "));
  }
  const std::string text = first_text(comm_, own);
  require<ConfigError>(text.empty(), text);
}

// Volumes are averaged over cells; triangles and tetrahedra are too small for that.
template <int dim>
void MpmSolver<dim>::prepare_averages() {
  const LockingCure& locking = settings_.locking;
  const CellType type = grid_.mesh.cell_type;
  if (locking.average_volumes && (type == CellType::tri3 || type == CellType::tet4)) {
    grid_.patches = join_cells(grid_.mesh, grid_.locator);
  }
  log::info("F-bar against volumetric locking: {} ({})", locking.average_volumes ? "on" : "off",
            locking.reason);
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
void MpmSolver<dim>::set_motion(std::vector<Vector<dim>> v, std::vector<Vector<dim>> a) {
  require(v.size() == points_.v.size() && a.size() == points_.a.size(),
          "mpm_solver: found {} velocities and {} accelerations for {} points", v.size(), a.size(),
          points_.size());
  points_.v = std::move(v);
  points_.a = std::move(a);
  ledger_.start(points_);
}

template <int dim>
void MpmSolver<dim>::check_initial_stress() {
  const InitialStress* strictest = nullptr;
  for (const auto& stress : settings_.initial_stress) {
    if (stress && (!strictest || stress->max_displacement < strictest->max_displacement)) {
      strictest = &*stress;
    }
  }
  if (!strictest) return;
  with_inertia_ = false;
  map_to_nodes();
  make_equilibrium(phase().gravity_ramp.at(0), phase().gravity_ramp.at(0), 1);
  receive({});
  move_rigid_walls(0);
  const std::size_t n = static_cast<std::size_t>(nodes_.size()) * dim;
  std::vector<double> du(n, 0.0), r(n);
  equilibrium_->evaluate(du, r, &K_);
  wall_forces_ = forces_on_walls();
  linear_.set_matrix(K_);
  linear_.solve(r, du);
  double largest = 0;
  for (std::size_t i = 0; i < n; i += dim) {
    largest = std::max(largest, norm_of(std::span<const double>(du).subspan(i, dim)));
  }
  initial_displacement_ = largest;
  log::info("initial stress: would settle by {:.2e} m, {:.2e} of a cell", largest,
            largest / cell_size_);
  require<ConfigError>(
      largest <= strictest->max_displacement * cell_size_,
      "{}: the initial stress is not in balance, a node would move by {:.3g} cells; "
      "allowed: \"max_displacement\" = {:g}",
      strictest->where, largest / cell_size_, strictest->max_displacement);
}

template <int dim>
StepReport MpmSolver<dim>::try_step(const StepRequest& request, const InterfaceValues& received,
                                    InterfaceValues& sent) {
  const bool begins = dt_ != request.dt;
  if (begins) {
    log_new_dt(request);
    begin_step(request);
  }
  receive(received);
  move_rigid_walls(request.time + request.dt);
  if (begins || request.iteration == 0) {
    equilibrium_->internal_forces().forget();
    choose_guess();
  }
  equilibrium_->internal_forces().begin_solution();
  NewtonMatrix<dim> matrix{K_, linear_};
  const NewtonReport newton =
      solve_newton<dim>(*equilibrium_, matrix, settings_.newton, du_, times_);
  linear_iterations_ += newton.linear_iterations;
  newton_counts_.add_solution(newton.iterations);
  step_newton_ = std::max(step_newton_, newton.iterations);
  log::debug("step {} iteration {}: |r|/scale {:.1e}, {} linear iterations", request.step,
             request.iteration, fmt::join(newton.residuals, " "), newton.linear_iterations);
  if (settings_.outside == Outside::error) refuse_exits();

  StepReport report;
  report.newton_iterations = newton.iterations;
  report.linear_iterations = newton.linear_iterations;
  report_contact(report, sent);
  return report;
}

template <int dim>
AcceptReport MpmSolver<dim>::accept_step(const StepRequest& request, bool solved) {
  require(solved && dt_ == request.dt, "mpm_solver: a step was accepted that was not solved");
  const ScopedTimer timer(times_, "grid to points");
  wall_forces_ = forces_on_walls();
  rigid_wall_forces_ = forces_on_rigid_walls();
  equilibrium_->internal_forces().finish(du_);
  const double time = request.time + request.dt;
  propose_dt(time);
  const NodalMotion<dim> motion = nodal_motion();
  const StepBalance<dim> balance =
      step_balance(*equilibrium_, std::span<const double>(du_), motion);
  deform_points<dim>(nodes_, du_, weights_, points_);
  capped_domains_ += weights_.num_capped;
  grid_to_points(nodes_, motion, weights_, settings_.pic_share, points_);
  if (!with_inertia_) {
    std::fill(points_.v.begin(), points_.v.end(), Vector<dim>::Zero());
    std::fill(points_.a.begin(), points_.a.end(), Vector<dim>::Zero());
  }
  double dissipated = 0;
  for (std::int32_t e = 0; e < points_.size(); ++e) {
    const std::int32_t p = weights_.point[e];
    const Symmetric<dim> mean_tau = (points_.tau[p] + trial_.tau[e]) / 2;
    dissipated += points_.V0[p] * contract<dim>(mean_tau, trial_.plastic_increment[e]);
    points_.history[p] = trial_.history[e];
    points_.tau[p] = trial_.tau[e];
    points_.energy[p] = trial_.energy[e];
    points_.J[p] *= trial_.J_ratio[e];
  }
  ledger_.add_step(balance, scheme_, dt_, dissipated, points_);
  for (auto& boundary : boundaries_) boundary.accept();
  const std::vector<std::int32_t> cell_n = points_.cell;
  const auto outside = find_cells(grid_, points_);
  dt_ = 0;
  AcceptReport report;
  report.details = accepted_details(cell_n);
  remove_outside(outside);
  report.probes = probes();
  report.proposed_dt = proposal_.dt;
  return report;
}

template class MpmSolver<2>;
template class MpmSolver<3>;

}  // namespace gabion::mpm
