// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step/fractional_step.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/base/error.hpp"

namespace gabion::mpm {

namespace {

// Residual that a substep may leave: as a share of the one it begins with, and of the volume of the
// soil.
constexpr double left_over = 1e-8, round_off = 1e-14;

// Residual that a correction leaves of the one before it: evaluations cost as much as few products.
constexpr double linear_tolerance = 1e-2;

// Iterations that outlets may add to twice those after a set-up until it pays to set up anew.
constexpr int few_iterations = 5;

constexpr int most_iterations = 40;

// Most sets of places where rain runs off in a substep; mostly one or two suffice.
constexpr int most_changes_of_outlets = 20;

}  // namespace

template <int dim>
void FractionalStep<dim>::begin(double dt) {
  dt_ = dt;
  SeepageStepData<dim> data = parts_.water.data;
  data.dt = dt;
  data.inertia_slope = 1 / (dt * dt);
  data.by_inertia = true;
  water_.emplace(parts_.stress, data);
  q_ = water_->start_heads();
  held_.clear();
  for (const char wet : water_->wet()) held_.push_back(wet ? 0 : 1);
  for (std::size_t k = 0; k < parts_.water.drained.nodes.size(); ++k) {
    const std::int32_t i = parts_.water.drained.nodes[k];
    if (held_[i] == 1) continue;
    held_[i] = 2;
    q_[i] = parts_.water.drained.q[k];
  }
  work_ = supplied_work_ = rain_in_ = rain_run_off_ = 0;
  pool_impulse_.setZero();
  iterations_ = 0;
  water_->find_start_forces();
  f_start_ = water_->forces();
  f_pool_start_ = water_->pool_forces();
  u_.assign(f_start_.size(), 0.0);
  set_matrix();
  f_old_ = water_->forces();
}

// The matrix of the accepted state, and forces and volumes there. Solutions with the same substeps
// have the same matrix, and the same solver unless one of them set it up once more.
template <int dim>
void FractionalStep<dim>::set_matrix() {
  const bool known = matrix_ && matrix_dt_ == dt_;
  if (known) {
    matrix_->storage() = closed_;
  } else {
    if (K_.pattern_id() == 0) make_pattern();
    evaluate(true);
    matrix_.emplace(typename PressureMatrix<dim>::Parts{parts_.stress, parts_.walls, parts_.inertia,
                                                        parts_.water.data.averages},
                    K_, dt_);
    matrix_dt_ = dt_;
    closed_ = matrix_->storage();
  }
  if (!parts_.water.surface.empty())
    water_->open(*parts_.stress.context->grid, parts_.water.surface);
  evaluate(false);
  update_outlets();
  least_iterations_ = 0;
  if (!known || !first_solver_) {
    set_up();
    first_solver_ = true;
  }
}

template <int dim>
void FractionalStep<dim>::update_outlets() {
  matrix_->change(parts_.stress, water_->take_outlet_changes());
}

template <int dim>
void FractionalStep<dim>::make_pattern() {
  std::vector<std::int32_t> offsets(1, 0), cell_nodes;
  for (const CellGroup& group : parts_.stress.weights.groups) {
    for (const std::int32_t node : parts_.stress.weights.nodes_of(group)) {
      cell_nodes.push_back(parts_.stress.nodes.active[node]);
    }
    offsets.push_back(static_cast<std::int32_t>(cell_nodes.size()));
  }
  K_.set_pattern(parts_.stress.nodes.size(), offsets, cell_nodes);
}

// Evaluate forces and volumes at u_, q_.
template <int dim>
void FractionalStep<dim>::evaluate(bool with_K) {
  RefusedPoint worst;
  if (with_K) K_.set_zero();
  if (water_->evaluate({.du = u_, .q = q_}, with_K ? &K_ : nullptr, worst)) return;
  throw ConvergenceError(
      fmt::format("explicit step: material point {} {}", parts_.stress.points.id[worst.point],
                  refusal_text(worst.refusal)),
      "inadmissible");
}

template <int dim>
void FractionalStep<dim>::set_up(bool lump) {
  least_iterations_ = 0;
  first_solver_ = false;
  lumped_ = lump;
  solver_ = std::make_unique<PressureSolver>(
      matrix_->near(held_, lump),
      [this](std::span<const double> q, std::span<double> r) { matrix_->multiply(q, held_, r); });
}

// dq of (W23) to a tolerance of the residual. Outlets that changed since the solver was set up cost
// it iterations, until it is set up once more.
template <int dim>
void FractionalStep<dim>::correct(double tolerance, std::vector<double>& dq) {
  std::optional<int> needed = solver_->solve(r_, dq, tolerance);
  if (!needed && !lumped_) {
    set_up(true);
    needed = solver_->solve(r_, dq, tolerance);
  }
  if (!needed) {
    throw ConvergenceError("explicit step: pore pressures: conjugate gradients do not converge",
                           "pore_pressures");
  }
  iterations_ += *needed;
  if (least_iterations_ == 0) least_iterations_ = *needed;
  if (*needed > 2 * least_iterations_ + few_iterations) set_up(lumped_);
}

template <int dim>
void FractionalStep<dim>::respond(std::span<const double> f, std::vector<double>& A) const {
  std::vector<double> free(f.begin(), f.end());
  parts_.walls.project(free);
  A.resize(f.size());
  parts_.inertia.apply(free, A);
  parts_.walls.project(A);
}

// Norm of the volume missing at the free nodes [m^3]; r_ is its negative.
template <int dim>
double FractionalStep<dim>::residual() {
  r_.resize(q_.size());
  double sum = 0;
  for (std::size_t i = 0; i < r_.size(); ++i) {
    r_[i] = held_[i] != 0 ? 0 : -water_->volumes()[i];
    sum += r_[i] * r_[i];
  }
  return std::sqrt(sum);
}

// u_ = u* + dt^2 A(F).
template <int dim>
void FractionalStep<dim>::move(std::span<const double> u) {
  respond(F_, A_);
  for (std::size_t k = 0; k < u.size(); ++k) u_[k] = u[k] + dt_ * dt_ * A_[k];
}

template <int dim>
void FractionalStep<dim>::solve(std::span<double> u) {
  F_.resize(u.size());
  for (std::size_t k = 0; k < u.size(); ++k) F_[k] = f_old_[k] - f_start_[k];
  move(u);
  evaluate(false);
  double soil = 0;
  const auto& weights = parts_.stress.weights;
  for (const double V : weights.volume) soil += V * V;
  double r = residual();
  const double enough = std::max(left_over * r, round_off * std::sqrt(soil));
  std::vector<double> dq(q_.size());
  for (int k = 0, changes = 0;; ++k) {  // changes of places where rain runs off
    if (r <= enough) {
      if (!water_->update_outlets()) break;
      if (++changes > most_changes_of_outlets) {
        throw ConvergenceError("explicit step: places where rain runs off change without end",
                               "pore_pressures");
      }
      evaluate(false);
      r = residual();
      if (r <= enough) continue;
    }
    if (k == most_iterations || !std::isfinite(r)) {
      throw ConvergenceError(
          fmt::format("explicit step: pore pressures: {:.3g} m^3 of water are missing after {} "
                      "iterations, allowed: {:.3g}",
                      r, k, enough),
          "pore_pressures");
    }
    update_outlets();
    correct(std::max(linear_tolerance, 0.1 * enough / r), dq);
    for (std::size_t i = 0; i < q_.size(); ++i) q_[i] += held_[i] != 0 ? 0 : dq[i];
    matrix_->add_forces(dq, F_);
    move(u);
    evaluate(false);
    r = residual();
  }
  std::ranges::copy(u_, u.begin());
}

template <int dim>
void FractionalStep<dim>::end_substep(std::span<const double> move) {
  const std::vector<double>& f = water_->forces();
  for (std::size_t k = 0; k < move.size(); ++k) {
    work_ += move[k] * (0.5 * (f_start_[k] + f[k]) + F_[k]);
  }
  f_start_ = f_old_ = f;
  add_supplies(move);
  water_->carry_on();
}

// Add what pools and rain do in the substep.
template <int dim>
void FractionalStep<dim>::add_supplies(std::span<const double> move) {
  supplied_work_ += water_->inflow_work();
  rain_in_ += water_->rain_in();
  rain_run_off_ += water_->rain_run_off();
  const std::vector<double>& f = water_->pool_forces();
  for (std::size_t k = 0; k < f.size(); ++k) {
    const double mean = 0.5 * (f_pool_start_[k] + f[k]);
    supplied_work_ += move[k] * mean;
    pool_impulse_[static_cast<Eigen::Index>(k % dim)] += dt_ * mean;
  }
  f_pool_start_ = f;
}

template <int dim>
bool FractionalStep<dim>::subtract_pools(std::span<double> internal) const {
  for (std::size_t k = 0; k < f_pool_start_.size(); ++k) internal[k] -= f_pool_start_[k];
  return !f_pool_start_.empty();
}

template <int dim>
double FractionalStep<dim>::supplied_work() const {
  double work = supplied_work_;
  const DrainedNodes& drained = parts_.water.drained;
  for (std::size_t k = 0; k < drained.nodes.size(); ++k) {
    const std::int32_t i = drained.nodes[k];
    if (held_[i] == 2) work += drained.p[k] * water_->volumes()[i];
  }
  return work;
}

template <int dim>
double FractionalStep<dim>::outflow() const {
  double sum = water_->outflow();
  for (std::size_t i = 0; i < held_.size(); ++i) {
    if (held_[i] == 2) sum -= water_->volumes()[i];
  }
  return sum;
}

template class FractionalStep<2>;
template class FractionalStep<3>;

}  // namespace gabion::mpm
