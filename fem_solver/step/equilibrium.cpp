// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/step/equilibrium.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>
#include <variant>

#include "common/base/require.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "common/mechanics/ranks/text.hpp"
#include "fem_solver/step/static_newton.hpp"
#include "fem_solver/stress/cell_damage.hpp"
#include "fem_solver/stress/cell_failure.hpp"
#include "fem_solver/stress/cells_of_materials.hpp"
#include "fem_solver/supports/link_nodes.hpp"

namespace gabion::fem {

namespace {

constexpr std::size_t large_dofs = 3000;  // in space
constexpr double support_share = 1e-2;    // of the stiffness of taut lines

// Share of the force that would stop the structure within the step: the residual is compared with
// it too, since a structure that flies freely has no other force.
constexpr double share_of_stopping = 1e-3;

template <int dim>
CellIntegrals<dim> make_cells(const FemSettings<dim>& settings) {
  std::optional<CellIntegrals<dim>> cells;
  together<ConfigError>(settings.ranks.comm(), [&] {
    refuse_loose_cells<dim>(settings.mesh, settings.materials, settings.ranks);
    cells.emplace(
        settings.mesh, settings.materials, settings.lumped_mass, settings.ranks,
        LinesOfMesh<dim>{settings.line_materials, settings.beam_nodes(), &settings.embedded});
  });
  cells->set_nodal_parts(nodal_parts(settings));
  cells->set_membranes({settings.mesh, settings.membranes, settings.lumped_mass});
  if (!settings.rigid_links.empty()) {
    cells->set_links({rigid_links(settings), settings.rotation_length});
  }
  return std::move(*cells);
}

}  // namespace

template <int dim>
Equilibrium<dim>::Equilibrium(const FemSettings<dim>& settings,
                              const BoundaryConditions<dim>& conditions, MPI_Comm comm)
    : comm_(comm),
      ranks_(settings.ranks),
      conditions_(conditions),
      embedded_(settings.embedded),
      mesh_(settings.mesh),
      cells_(make_cells(settings)),
      may_be_loose_(may_be_loose(settings)),
      may_fail_(fem::may_fail(cells_)),
      scheme_(settings.time_integration),
      smallest_cell_size_(-shared().largest(-cells_.smallest_cell_size())),
      num_dofs_(settings.mesh.nodes.size() * dim),
      num_nodes_of_all_(ranks_.num_nodes_of_all(settings.mesh)),
      constrained_(num_dofs_, 0) {
  require(ranks_.alone() == (num_ranks(comm) == 1),
          "fem_solver: found {} ranks for a mesh that is {}", num_ranks(comm),
          ranks_.alone() ? "whole" : "divided");
  for (const auto dof : conditions.constrained_dofs()) constrained_[dof] = 1;
  if (is_damped(settings)) damping_ = std::make_unique<Damping<dim>>(settings, cells_);
  find_wave_speed(settings);
  set_history(nullptr);
  forces_.internal.assign(num_dofs_, 0.0);
  forces_.inertia.assign(num_dofs_, 0.0);
  u_trial_.resize(num_dofs_);
  a_mean_.resize(num_dofs_);
}

template <int dim>
void Equilibrium<dim>::find_wave_speed(const FemSettings<dim>& settings) {
  wave_speed_ = cells_.membranes().wave_speed();
  for (const CellMaterial<dim>& material : settings.materials) {
    std::visit(
        [&](const auto& law) {
          symmetric_ = symmetric_ && law.symmetric_tangent();
          wave_speed_ = std::max(wave_speed_, std::sqrt(law.p_wave_modulus() / material.density));
        },
        material.law);
  }
  for (const LineMaterial& material : settings.line_materials) {
    if (material.beam && dim == 3) symmetric_ = false;  // moments on spins
    wave_speed_ = std::max(wave_speed_, std::sqrt(material.young_modulus / material.density));
  }
}

template <int dim>
bool Equilibrium<dim>::regularise(double share) {
  regularisation_share_ = share;
  return may_be_loose_;
}

template <int dim>
bool Equilibrium<dim>::support(bool on) {
  support_ = on;
  return may_be_loose_;
}

template <int dim>
const CellHistory& Equilibrium<dim>::set_history(CellHistory history) {
  const std::size_t size = cells_.history_size();
  if (!history && cells_.history_width() > 0) {
    history = std::make_shared<const std::vector<double>>(size, 0.0);
  }
  assert(!history || history->size() == size);
  history_n_ = std::move(history);
  trial_history_.resize(size);
  return history_n_;
}

template <int dim>
HistoryStep Equilibrium<dim>::history_step() {
  if (!history_n_) return {};
  return {.accepted = *history_n_, .trial = trial_history_};
}

template <int dim>
void Equilibrium<dim>::find_history(StructureState& state, const StructureState* before) const {
  state.history.reset();
  state.plastic_work = 0;
  state.brake_work = 0;
  state.damage_work = 0;
  if (!history_n_) return;
  state.history = std::make_shared<const std::vector<double>>(trial_history_);
  // The work of failing cells counts with the share of their stress left in this step.
  const bool by_step = may_fail_ && before;
  if (before) state.failed_energy = before->failed_energy;
  const auto work = [&](double StructureState::*sum, const auto& of_history) {
    state.*sum = shared().total(of_history(trial_history_));
    if (by_step) state.*sum += before->*sum - shared().total(of_history(*history_n_));
  };
  work(&StructureState::plastic_work,
       [&](std::span<const double> history) { return cells_.plastic_work(history); });
  if (cracks()) {
    work(&StructureState::damage_work,
         [&](std::span<const double> history) { return damage_work<dim>(cells_, history); });
  }
  if (!cells_.line_blocks().empty()) {
    work(&StructureState::brake_work,
         [&](std::span<const double> history) { return cells_.brake_work(history); });
  }
}

template <int dim>
typename Equilibrium<dim>::InternalForces Equilibrium<dim>::internal_forces(
    std::span<const double> u, const CellHistory& history) {
  set_history(history);
  InternalForces result{.f = std::vector<double>(num_dofs_, 0.0)};
  const StressIntegral stresses = cells_.add_internal(u, result.f, nullptr, history_step());
  shared().sum(result.f, dim);
  result.energy = shared().total(stresses.energy);
  return result;
}

template <int dim>
void Equilibrium<dim>::begin_step(const StructureMotion& motion_n, std::span<const double> f_ext,
                                  std::span<const double> f_start, double dt, bool with_inertia) {
  motion_n_ = &motion_n;
  f_ext_.assign(f_ext.begin(), f_ext.end());
  const double memory = with_inertia ? scheme_.force_memory() : 0;
  for (std::size_t i = 0; i < f_start.size(); ++i) f_ext_[i] += memory * f_start[i];
  dt_ = dt;
  with_inertia_ = with_inertia;
  start_force_ = with_inertia ? share_of_stopping / dt * shared().norm(mass_times(motion_n.v))
                              : shared().norm(f_start);
}

template <int dim>
double Equilibrium<dim>::end_acceleration(std::size_t dof, double du) const {
  if (constrained_[dof]) return (du / dt_ - motion_n_->v[dof]) / dt_;
  return scheme_.acceleration(du, motion_n_->v[dof], motion_n_->a[dof], dt_);
}

/// @param a  end_acceleration() of it
template <int dim>
double Equilibrium<dim>::end_velocity(std::size_t dof, double du, double a) const {
  if (constrained_[dof]) return du / dt_;
  return scheme_.velocity(a, motion_n_->v[dof], motion_n_->a[dof], dt_);
}

template <int dim>
typename Equilibrium<dim>::CellSums Equilibrium<dim>::sum_cells(std::span<const double> du,
                                                                BlockMatrix<dim>* K) {
  buffer_.assign(2 * num_dofs_, 0.0);
  const std::span<double> internal(buffer_.data(), num_dofs_);
  const std::span<double> inertia(buffer_.data() + num_dofs_, num_dofs_);
  const StressIntegral stresses = cells_.add_internal(u_trial_, internal, K, history_step());
  if (with_inertia_) {
    for (std::size_t i = 0; i < num_dofs_; ++i) {
      a_mean_[i] = scheme_.inertia(end_acceleration(i, du[i]), motion_n_->a[i]);
    }
    cells_.add_mass_times(a_mean_, inertia);
    if (damping_) {
      v_trial_.resize(num_dofs_);
      for (std::size_t i = 0; i < num_dofs_; ++i) {
        v_trial_[i] = end_velocity(i, du[i], end_acceleration(i, du[i]));
      }
      damping_->add_times(v_trial_, internal);
    }
    shared().sum(internal, inertia, dim);
  } else {
    shared().sum(internal, dim);
  }
  const double line_share =
      support_ ? std::max(support_share, regularisation_share_) : regularisation_share_;
  if (K && line_share > 0) cells_.add_line_stiffness(line_share, *K);
  std::string fault;
  if (const std::int32_t c = stresses.inadmissible_cell; c >= cells_.num_cells()) {
    fault =
        fmt::format("{} in line {}", stresses.fault, ranks_.line_of_all(c - cells_.num_cells()));
  } else if (c >= 0) {
    fault = fmt::format("{} in cell {}", stresses.fault, ranks_.cell_of_all(c));
  }
  return {.internal = internal, .inertia = inertia, .energy = stresses.energy, .fault = fault};
}

template <int dim>
std::string Equilibrium<dim>::find_residual(const CellSums& sums, std::span<double> r) const {
  std::string fault;
  for (std::size_t i = 0; i < num_dofs_; ++i) {
    const double internal = sums.internal[i], inertia = sums.inertia[i];
    r[i] = constrained_[i] ? 0.0 : f_ext_[i] - internal - inertia;
    if (std::isfinite(internal) && std::isfinite(inertia) && std::isfinite(f_ext_[i])) continue;
    if (fault.empty()) fault = "force not finite at " + describe_node(i / dim);
  }
  return fault;
}

template <int dim>
Evaluation Equilibrium<dim>::evaluate(std::span<const double> du, std::span<double> r,
                                      BlockMatrix<dim>* K) {
  assert(motion_n_ && du.size() == num_dofs_ && r.size() == num_dofs_);
  for (std::size_t i = 0; i < num_dofs_; ++i) u_trial_[i] = motion_n_->u[i] + du[i];
  if (K) K->set_zero();
  const CellSums sums = sum_cells(du, K);
  const std::string not_finite = find_residual(sums, r);
  const auto own_square = [this](std::span<const double> a) { return shared().own_dot(a, a); };
  std::array<double, 7> totals = {sums.energy,
                                  sums.fault.empty() ? 0.0 : 1.0,
                                  not_finite.empty() ? 0.0 : 1.0,
                                  own_square(sums.internal),
                                  own_square(sums.inertia),
                                  own_square(f_ext_),
                                  own_square(r)};
  shared().total(totals);
  const auto& [energy, faults, not_finites, internal, inertia, external, residual] = totals;
  if (faults > 0) return {.admissible = false, .reason = shared().first_text(sums.fault)};
  if (not_finites > 0) return {.admissible = false, .reason = shared().first_text(not_finite)};
  forces_.internal.assign(sums.internal.begin(), sums.internal.end());
  forces_.inertia.assign(sums.inertia.begin(), sums.inertia.end());
  forces_.elastic_energy = energy;
  if (K) {
    last_tangent_ = {
        .u = u_trial_, .dt = dt_, .with_inertia = with_inertia_, .history = history_n_};
    finish_tangent(dt_, with_inertia_, *K);
  }
  Evaluation result;
  result.force_scale = std::max(std::sqrt(std::max({internal, inertia, external})), start_force_);
  result.residual_norm = std::sqrt(residual);
  return result;
}

template <int dim>
void Equilibrium<dim>::finish_tangent(double dt, bool with_inertia, BlockMatrix<dim>& K) {
  if (with_inertia) cells_.add_mass(scheme_.inertia_slope(dt), K);
  if (with_inertia && damping_) damping_->add(scheme_.gamma / (scheme_.beta * dt), K);
  if (!with_inertia && may_fail_) hold_nodes_of_gone<dim>(cells_, mesh_, *history_n_, K);
  K.constrain(conditions_.constrained_nodes(), conditions_.projectors(),
              [this](std::int32_t i) { return shared().owns(i); });
}

template <int dim>
void Equilibrium<dim>::assemble_tangent(std::span<const double> u, double dt, bool with_inertia,
                                        BlockMatrix<dim>& K) {
  K.set_zero();
  buffer_.assign(num_dofs_, 0.0);
  cells_.add_internal(u, std::span<double>(buffer_), &K, history_step());
  last_tangent_ = {
      .u = {u.begin(), u.end()}, .dt = dt, .with_inertia = with_inertia, .history = history_n_};
  finish_tangent(dt, with_inertia, K);
}

template <int dim>
StructureMotion Equilibrium<dim>::motion_after(std::span<const double> du) const {
  StructureMotion next;
  next.u.resize(num_dofs_);
  next.v.assign(num_dofs_, 0.0);
  next.a.assign(num_dofs_, 0.0);
  for (std::size_t i = 0; i < num_dofs_; ++i) {
    next.u[i] = motion_n_->u[i] + du[i];
    if (!with_inertia_) continue;
    next.a[i] = end_acceleration(i, du[i]);
    next.v[i] = end_velocity(i, du[i], next.a[i]);
  }
  for (auto* y : {&next.u, &next.v, &next.a}) embedded_.follow(*y);
  return next;
}

template <int dim>
std::vector<double> Equilibrium<dim>::mass_times(std::span<const double> y) const {
  std::vector<double> result(num_dofs_, 0.0);
  cells_.add_mass_times(y, result);
  shared().sum(result, dim);
  return result;
}

template <int dim>
void Equilibrium<dim>::add_damping(std::span<const double> v, std::span<double> f) const {
  if (!damping_) return;
  std::vector<double> forces(num_dofs_, 0.0);
  damping_->add_times(v, forces);
  shared().sum(forces, dim);
  for (std::size_t i = 0; i < num_dofs_; ++i) f[i] += forces[i];
}

template <int dim>
double Equilibrium<dim>::damping_work(const StructureState& state_n, const StructureState& next,
                                      double dt) const {
  if (!damping_) return 0;
  std::vector<double> du(next.motion.u), forces(num_dofs_, 0.0);
  for (std::size_t i = 0; i < num_dofs_; ++i) du[i] -= state_n.motion.u[i];
  damping_->add_times(du, forces);
  const double work = std::inner_product(du.begin(), du.end(), forces.begin(), 0.0);
  return state_n.damping_work + shared().total(work) / dt;
}

template <int dim>
std::vector<double> Equilibrium<dim>::initial_acceleration(const StructureMotion& motion,
                                                           std::span<const double> f_ext) {
  std::vector<double> r(num_dofs_, 0.0), a(num_dofs_, 0.0);
  const StressIntegral stresses = cells_.add_internal(motion.u, r, nullptr, history_step());
  require<ConvergenceError>(shared().all(stresses.inadmissible_cell < 0),
                            "initial displacement: det F <= 0 in a cell");
  shared().sum(r, dim);
  add_damping(motion.v, r);
  bool balanced = true;
  for (std::size_t i = 0; i < num_dofs_; ++i) {
    r[i] = constrained_[i] ? 0.0 : f_ext[i] - r[i];
    balanced = balanced && r[i] == 0;
  }
  if (!shared().all(balanced)) factor_mass()->solver.solve(r, a);
  for (std::size_t i = 0; i < num_dofs_; ++i) {
    if (constrained_[i]) a[i] = 0;
  }
  return a;
}

template <int dim>
std::vector<double> Equilibrium<dim>::acceleration_of(std::span<const double> f) {
  std::vector<double> r(f.begin(), f.end()), a(num_dofs_, 0.0);
  for (std::size_t i = 0; i < num_dofs_; ++i) {
    if (constrained_[i]) r[i] = 0;
  }
  if (!mass_) mass_ = factor_mass();
  mass_->solver.solve(r, a);
  for (std::size_t i = 0; i < num_dofs_; ++i) {
    if (constrained_[i]) a[i] = 0;
  }
  return a;
}

template <int dim>
std::unique_ptr<typename Equilibrium<dim>::Mass> Equilibrium<dim>::factor_mass() const {
  // The mass matrix is well conditioned: where a factor would be large, it is solved by iterations
  // to the last digits.
  const bool large = dim == 3 && std::size_t{dim} * num_nodes_of_all_ > large_dofs;
  const LinearSolverSettings settings =
      large ? LinearSolverSettings{.method = "cg", .preconditioner = "jacobi", .tolerance = 1e-14}
            : LinearSolverSettings{.method = "lu"};
  auto mass = std::make_unique<Mass>(comm_, settings);
  BlockMatrix<dim>& M = mass->M;
  cells_.set_pattern(M);
  M.set_zero();
  cells_.add_mass(1, M);
  M.constrain(conditions_.constrained_nodes(), conditions_.projectors(),
              [this](std::int32_t i) { return shared().owns(i); });
  mass->solver.set_regime({.symmetric = true, .courant = 0}, num_nodes_of_all_);
  mass->solver.set_matrix(M, shared());
  if (ranks_.alone()) M = {};
  return mass;
}

template class Equilibrium<2>;
template class Equilibrium<3>;

}  // namespace gabion::fem
