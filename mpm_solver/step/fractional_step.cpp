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

// Tolerance of the linear solver: the derivative is that of the start of the step, so an iteration
// gains little beyond it.
constexpr double linear_tolerance = 1e-5;

constexpr int most_iterations = 40;

}  // namespace

template <int dim>
void FractionalStep<dim>::begin(double dt) {
  dt_ = dt;
  SeepageStepData<dim> data = parts_.water.data;
  data.dt = dt;
  data.inertia_slope = 1 / (dt * dt);
  data.by_inertia = true;
  water_.emplace(parts_.stress, data);
  if (!parts_.water.surface.empty())
    water_->open(*parts_.stress.context->grid, parts_.water.surface);
  q_ = water_->start_heads();
  held_.clear();
  for (const char wet : water_->wet()) held_.push_back(wet ? 0 : 1);
  for (std::size_t k = 0; k < parts_.water.drained.nodes.size(); ++k) {
    const std::int32_t i = parts_.water.drained.nodes[k];
    if (held_[i] == 1) continue;
    held_[i] = 2;
    q_[i] = parts_.water.drained.q[k];
  }
  work_ = 0;
  iterations_ = 0;
  water_->find_start_forces();
  f_start_ = water_->forces();
  u_.assign(f_start_.size(), 0.0);
  if (K_.pattern_id() == 0) make_pattern();
  evaluate(true);
  assemble();
  f_old_ = water_->forces();
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

// Take S and B from K, and set up the solver.
template <int dim>
void FractionalStep<dim>::assemble() {
  constexpr int n = dim + 1;
  const std::size_t count = K_.columns().size();
  S_.resize(count);
  B_.resize(count);
  const double* block = K_.values().data();
  for (std::size_t s = 0; s < count; ++s, block += n * n) {
    S_[s] = -block[dim * n + dim];
    for (int d = 0; d < dim; ++d) B_[s][d] = -block[dim * n + d];
  }
  SparseRows near;
  near.starts.assign(K_.row_starts().begin(), K_.row_starts().end());
  near.columns.assign(K_.columns().begin(), K_.columns().end());
  near.values = S_;
  add_inertia(near);
  // Where the soil ends, pressures push it away: constants show how much.
  std::vector<double> ones(q_.size(), 1.0), of_ones(q_.size());
  for (std::size_t i = 0; i < ones.size(); ++i) ones[i] = held_[i] != 0 ? 0 : 1;
  multiply(ones, of_ones);
  for (std::size_t i = 0; i < ones.size(); ++i) {
    double& diagonal = near.values[K_.diagonal()[i]];
    if (held_[i] == 0) diagonal += std::max(0.0, of_ones[i]);
    for (std::int32_t s = near.starts[i]; s < near.starts[i + 1]; ++s) {
      if (held_[i] == 0 && held_[near.columns[s]] == 0) continue;
      near.values[s] = 0;
    }
    if (held_[i] != 0) diagonal = 1;
  }
  solver_ = std::make_unique<PressureSolver>(
      std::move(near), [this](std::span<const double> q, std::span<double> r) { multiply(q, r); });
}

// dt^2 sum_p V / rho grad N_i . grad N_k.
template <int dim>
void FractionalStep<dim>::add_inertia(SparseRows& near) const {
  const auto& weights = parts_.stress.weights;
  const MaterialPoints<dim>& points = parts_.stress.points;
  std::array<std::int32_t, max_group_nodes<dim>> active;
  for (const CellGroup& group : weights.groups) {
    const auto& water = parts_.stress.bodies[group.body].water;
    if (!water || !water->drains()) continue;
    parts_.stress.nodes.list_active(weights.nodes_of(group), active.data());
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const std::int32_t p = weights.point[e];
      const double V = weights.volume[e] * points.J[p];
      const double share = dt_ * dt_ * V * V / points.m[p];
      for (int i = 0; i < weights.num_nodes(e); ++i) {
        const std::int32_t row = active[weights.local_of(e)[i]];
        const auto begin = near.columns.begin() + near.starts[row];
        const auto end = near.columns.begin() + near.starts[row + 1];
        for (int k = 0; k < weights.num_nodes(e); ++k) {
          const auto place = std::lower_bound(begin, end, active[weights.local_of(e)[k]]);
          near.values[place - near.columns.begin()] +=
              share * weights.grad_of(e)[i].dot(weights.grad_of(e)[k]);
        }
      }
    }
  }
}

template <int dim>
void FractionalStep<dim>::respond(std::span<const double> f, std::vector<double>& A) const {
  std::vector<double> free(f.begin(), f.end());
  parts_.walls.project(free);
  A.resize(f.size());
  parts_.inertia.apply(free, A);
  parts_.walls.project(A);
}

template <int dim>
void FractionalStep<dim>::add_gradient(std::span<const double> q, std::span<double> f) const {
  const auto starts = K_.row_starts(), columns = K_.columns();
  for (std::size_t i = 0; i < q.size(); ++i) {
    Eigen::Map<Vector<dim>> of_node(f.data() + i * dim);
    for (std::int32_t s = starts[i]; s < starts[i + 1]; ++s) of_node += B_[s] * q[columns[s]];
  }
}

template <int dim>
void FractionalStep<dim>::multiply(std::span<const double> q, std::span<double> r) const {
  const auto starts = K_.row_starts(), columns = K_.columns();
  std::vector<double> f(q.size() * dim, 0.0), A;
  add_gradient(q, f);
  respond(f, A);
  std::fill(r.begin(), r.end(), 0.0);
  for (std::size_t i = 0; i < q.size(); ++i) {
    const Vector<dim> moved = dt_ * dt_ * Eigen::Map<const Vector<dim>>(A.data() + i * dim);
    for (std::int32_t s = starts[i]; s < starts[i + 1]; ++s) {
      r[i] += S_[s] * q[columns[s]];
      r[columns[s]] += B_[s].dot(moved);
    }
  }
  for (std::size_t i = 0; i < q.size(); ++i) {
    if (held_[i] != 0) r[i] = q[i];
  }
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
  for (int k = 0; !(r <= enough); ++k) {
    if (k == most_iterations || !std::isfinite(r)) {
      throw ConvergenceError(
          fmt::format("explicit step: pore pressures: {:.3g} m^3 of water are missing after {} "
                      "iterations, allowed: {:.3g}",
                      r, k, enough),
          "pore_pressures");
    }
    if (water_->outlets_changed()) {
      evaluate(true);
      assemble();
    }
    iterations_ += solver_->solve(r_, dq, linear_tolerance);
    for (std::size_t i = 0; i < q_.size(); ++i) q_[i] += held_[i] != 0 ? 0 : dq[i];
    add_gradient(dq, F_);
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
  water_->carry_on();
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
