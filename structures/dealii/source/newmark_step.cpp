// SPDX-License-Identifier: BSD-3-Clause
#include "newmark_step.hpp"

#include <common/base/error.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace dealii_structure {

namespace {

constexpr double slow =
    0.25;  // an iteration that leaves more of the residual asks for a new factor
constexpr int max_halvings = 5;

}  // namespace

template <int dim>
NewmarkStep<dim>::NewmarkStep(const Settings& settings, const ElasticSolid<dim>& solid)
    : solid_(solid),
      newton_(settings.newton),
      initial_equilibrium_(settings.initial_equilibrium),
      alpha_(settings.alpha),
      beta_(0.25 * (1 - alpha_) * (1 - alpha_)),
      gamma_(0.5 - alpha_) {
  solid_.init(K_);
}

template <int dim>
Vector NewmarkStep<dim>::acceleration(const Balance& balance, const Vector& du) const {
  Vector a(du);
  const double dt = balance.dt;
  a *= 1 / (beta_ * dt * dt);
  a.add(-1 / (beta_ * dt), balance.state.v, -(0.5 / beta_ - 1), balance.state.a);
  return a;
}

/// r condensed, and its norm; `scale`: the largest norm of its terms. Nothing where J <= 0.
template <int dim>
std::optional<double> NewmarkStep<dim>::residual(const Balance& balance, const Vector& du,
                                                 Vector& r, double* scale) const {
  Vector u(balance.state.u), inner, load(balance.load), inertia(du.size());
  u += du;
  if (!solid_.internal_forces(u, inner)) return std::nullopt;
  if (balance.dt > 0) {
    Vector a = acceleration(balance, du);
    a.sadd(1 - alpha_, alpha_, balance.state.a);
    inertia = solid_.mass_times(a);
  }
  for (Vector* term : {&inner, &load, &inertia}) solid_.condense(*term);
  r = load;
  r -= inner;
  r -= inertia;
  if (scale) *scale = std::max({load.l2_norm(), inner.l2_norm(), inertia.l2_norm()});
  return r.l2_norm();
}

template <int dim>
void NewmarkStep<dim>::factorise(std::shared_ptr<const TangentPoint> point) {
  if (held_ == point) return;
  held_.reset();
  const double dt = point->dt;
  solid_.assemble(point->u, dt > 0 ? (1 - alpha_) / (beta_ * dt * dt) : 0, K_);
  try {
    factor_.factorize(K_);
  } catch (const std::exception&) {
    throw gabion::ConvergenceError("the tangent is singular: are there supports?", "singular");
  }
  ++factorisations_;
  held_ = std::move(point);
}

/// du <- du + K^-1 r, or a part of it that can be deformed so. @returns the norm of the new r
template <int dim>
double NewmarkStep<dim>::follow(const Balance& balance, Vector& du, Vector& r) const {
  Vector step(r.size());
  factor_.vmult(step, r);
  solid_.constraints().distribute(step);
  for (int halving = 0; halving <= max_halvings; ++halving) {
    Vector next(du);
    next += step;
    if (const auto norm = residual(balance, next, r, nullptr); norm && std::isfinite(*norm)) {
      du = next;
      return *norm;
    }
    step *= 0.5;
  }
  throw gabion::ConvergenceError("cells turn inside out", "inverted");
}

/// Smallest residual that rounding allows: |K_ii u_i| times a few units of the last bit, which
/// matters where a body has moved far.
template <int dim>
double NewmarkStep<dim>::rounding(const Balance& balance, const Vector& du) const {
  double sum = 0;
  for (unsigned i = 0; i < du.size(); ++i) {
    if (solid_.constraints().is_constrained(i)) continue;
    const double force = K_.diag_element(i) * (balance.state.u[i] + du[i]);
    sum += force * force;
  }
  return 4 * std::numeric_limits<double>::epsilon() * std::sqrt(sum);
}

template <int dim>
int NewmarkStep<dim>::find_balance(const Balance& balance, Vector& du,
                                   std::shared_ptr<const TangentPoint> point) {
  Vector r;
  double scale = 0;
  auto first = residual(balance, du, r, &scale);
  if (!first) throw gabion::ConvergenceError("cells turn inside out in the guess", "inverted");
  double norm = *first;
  factorise(point);
  for (int iteration = 0; iteration < newton_.max_iterations; ++iteration) {
    if (norm <= std::max(newton_.tolerance * scale, rounding(balance, du))) return iteration;
    factorise(point);
    const double next = follow(balance, du, r);
    if (next > slow * norm) {
      Vector u(balance.state.u);
      u += du;
      point = std::make_shared<TangentPoint>(TangentPoint{std::move(u), balance.dt});
    }
    norm = *residual(balance, du, r, &scale);
  }
  if (norm <= newton_.tolerance * scale) return newton_.max_iterations;
  throw gabion::ConvergenceError("no balance after " + std::to_string(newton_.max_iterations) +
                                     " iterations: residual " + std::to_string(norm / scale) +
                                     " of the forces",
                                 "iteration_limit");
}

template <int dim>
Vector NewmarkStep<dim>::inverse_mass_times(const Vector& f) {
  if (!mass_factor_) {
    dealii::SparseMatrix<double> M;
    solid_.init(M);
    solid_.assemble_mass(M);
    mass_factor_ = std::make_unique<dealii::SparseDirectUMFPACK>();
    mass_factor_->factorize(M);
  }
  Vector condensed(f), a(f.size());
  solid_.condense(condensed);
  mass_factor_->vmult(a, condensed);
  solid_.constraints().distribute(a);
  return a;
}

template <int dim>
SolidState NewmarkStep<dim>::initial_state() {
  const Vector zero(solid_.num_dofs());
  SolidState state{zero, zero, zero, {zero, zero}, true, nullptr};
  if (initial_equilibrium_) {
    Vector du(zero);
    const auto point = std::make_shared<TangentPoint>(TangentPoint{zero, 0});
    find_balance({state, solid_.weight(), 0}, du, point);
    state.u = du;
  } else {
    state.a = inverse_mass_times(solid_.weight());
    state.balanced = solid_.weight().all_zero();
  }
  held_.reset();
  return state;
}

template <int dim>
int NewmarkStep<dim>::solve(const SolidState& state, const WetForces& forces, double dt,
                            SolidState& trial) {
  const bool still = state.balanced && state.v.all_zero() && state.a.all_zero();
  if (still && forces == state.forces) {
    trial = state;
    return 0;
  }
  const double c = (1 - alpha_) / (2 * beta_);
  Balance balance{state, solid_.weight(), dt};
  balance.load += forces.end;
  balance.load.add(c, forces.mean, -(c - 1), state.forces.mean);
  Vector du(state.v), guess(state.u);
  du *= dt;
  guess += du;
  auto point = state.tangent;
  if (!point || point->dt != dt) point = std::make_shared<TangentPoint>(TangentPoint{guess, dt});
  int iterations = 0;
  try {
    iterations = find_balance(balance, du, point);
  } catch (const gabion::ConvergenceError&) {  // nodes that are too fast after an impact
    du = 0;
    point = std::make_shared<TangentPoint>(TangentPoint{state.u, dt});
    iterations = newton_.max_iterations + find_balance(balance, du, point);
  }
  trial.u = state.u;
  trial.u += du;
  trial.a = acceleration(balance, du);
  trial.v = state.v;
  trial.v.add(dt * (1 - gamma_), state.a, dt * gamma_, trial.a);
  trial.forces = forces;
  trial.balanced = true;
  trial.tangent = held_ ? held_ : point;
  return iterations;
}

template <int dim>
void NewmarkStep<dim>::complete(const SolidState& state, double dt, SolidState& trial) {
  if (trial.forces.mean == state.forces.mean) return;
  Vector change(trial.forces.mean);
  change -= state.forces.mean;
  const Vector y = inverse_mass_times(change);
  trial.v.add(dt * (1 - gamma_ / (2 * beta_)), y);
  trial.a.add(-(0.5 / beta_ - 1), y);
}

template class NewmarkStep<2>;
template class NewmarkStep<3>;

}  // namespace dealii_structure
