// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/matrices/linear_step.hpp"

#include <algorithm>
#include <span>

#include "common/base/require.hpp"

namespace gabion::fem {

namespace {

using Eigen::VectorXd;

void require_finite(const VectorXd& x, double dt) {
  require<ConvergenceError>(x.allFinite(), "linear structure: displacement not finite, dt = {} s",
                            dt);
}

}  // namespace

void LinearState::visit_state(StateVisitor& visitor) {
  const auto vector = [&](const char* name, VectorXd& x) {
    visitor.reals(name, std::span<double>(x.data(), static_cast<std::size_t>(x.size())));
  };
  visitor.real("time", time);
  vector("u", u);
  vector("v", v);
  vector("a", a);
  vector("f_end", f.end);
  vector("f_step", f.step);
  visitor.flag("balanced", balanced);
  visitor.real("external_work", external_work);
  visitor.real("damping_work", damping_work);
}

LinearStep::LinearStep(const LinearModel& model, const NewmarkBossak& scheme, bool dynamic)
    : model_(model), scheme_(scheme), dynamic_(dynamic) {
  if (dynamic_) {
    mass_.emplace(model_.M, model_.unknowns, "mass");
  } else {
    factor(0);
  }
}

LinearState LinearStep::state_of(VectorXd u, VectorXd v, const VectorXd& load) const {
  LinearState state;
  const VectorXd zero = VectorXd::Zero(model_.size());
  VectorXd r = load - model_.K * u;
  if (model_.damped()) r -= model_.C * v;
  state.a = dynamic_ ? mass_->solve(r) : zero;
  state.u = std::move(u);
  state.v = std::move(v);
  state.f = {.end = load, .step = zero};
  state.balanced = dynamic_ || r.isZero(0);
  return state;
}

LinearState LinearStep::equilibrium(const VectorXd& load) const {
  LinearState state;
  const VectorXd zero = VectorXd::Zero(model_.size());
  state.u = load.isZero(0)
                ? zero
                : SymmetricFactor(model_.K, model_.unknowns, "initial equilibrium: stiffness")
                      .solve(load);
  state.v = state.a = zero;
  state.f = {.end = load, .step = zero};
  state.balanced = true;
  return state;
}

const SymmetricFactor& LinearStep::factor(double dt) {
  const auto found = std::find_if(factors_.begin(), factors_.end(),
                                  [dt](const KeptFactor& kept) { return kept.dt == dt; });
  if (found != factors_.end()) {
    factors_.splice(factors_.begin(), factors_, found);
    return *factors_.front().factor;
  }
  const ScopedTimer timer(times_, "factorisation");
  if (factors_.size() == kept_factors) factors_.pop_back();
  SparseMatrix A = model_.K;
  if (dynamic_) {
    A += scheme_.inertia_slope(dt) * model_.M;
    if (model_.damped()) A += scheme_.gamma / (scheme_.beta * dt) * model_.C;
  }
  const char* what = dynamic_ ? "stiffness with inertia" : "stiffness";
  factors_.push_front({dt, std::make_unique<SymmetricFactor>(A, model_.unknowns, what)});
  ++factorisations_;
  return *factors_.front().factor;
}

const VectorXd& LinearStep::start_forces(const LinearState& state_n, double dt) {
  if (start_ && start_->dt == dt) return start_->forces;
  VectorXd f = -(model_.K * state_n.u);
  if (dynamic_) {
    VectorXd inertia(f.size()), v_end(f.size());
    for (int i = 0; i < f.size(); ++i) {
      const double a_end = scheme_.acceleration(0, state_n.v[i], state_n.a[i], dt);
      inertia[i] = scheme_.inertia(a_end, state_n.a[i]);
      v_end[i] = scheme_.velocity(a_end, state_n.v[i], state_n.a[i], dt);
    }
    f -= model_.M * inertia;
    if (model_.damped()) f -= model_.C * v_end;
    if (const double memory = scheme_.force_memory(); memory > 0) {
      f += memory * (state_n.f.end - model_.K * state_n.u);
      if (model_.damped()) f -= memory * (model_.C * state_n.v);
    }
  }
  start_ = Start{.dt = dt, .forces = std::move(f)};
  return start_->forces;
}

/// M^-1 of the change of the mean forces; empty: they are as in the step before.
VectorXd LinearStep::mean_force_change(const LinearState& state_n, const LinearForces& f) const {
  if (!dynamic_ || f.step == state_n.f.step) return {};
  return mass_->solve(VectorXd(f.step - state_n.f.step));
}

bool LinearStep::nothing_changes(const LinearState& state_n, const LinearForces& f) const {
  return state_n.balanced && state_n.is_still() && f.end == state_n.f.end &&
         f.step == state_n.f.step;
}

VectorXd LinearStep::solve(const LinearState& state_n, const LinearForces& f, double dt) {
  if (nothing_changes(state_n, f)) {
    ++skipped_;
    return state_n.u;
  }
  const SymmetricFactor& A = factor(dynamic_ ? dt : 0);
  const ScopedTimer timer(times_, "solve");
  const double c = dynamic_ ? scheme_.step_force_weight() : 1;
  VectorXd r = start_forces(state_n, dt) + f.end + c * f.step - (c - 1) * state_n.f.step;
  // The velocity that damping sees has the correction of complete steps.
  if (const double share = scheme_.step_force_velocity(); model_.damped() && share != 0) {
    const VectorXd y = mean_force_change(state_n, f);
    if (y.size() > 0) r -= model_.C * (dt * share * y);
  }
  VectorXd u = state_n.u + A.solve(r);
  require_finite(u, dt);
  ++solves_;
  return u;
}

LinearState LinearStep::after(const LinearState& state_n, LinearForces f, VectorXd u,
                              double dt) const {
  LinearState next = state_n;
  next.time = state_n.time + dt;
  if (nothing_changes(state_n, f)) return next;
  const VectorXd du = u - state_n.u;
  next.u = std::move(u);
  next.balanced = true;
  if (dynamic_) {
    for (int i = 0; i < du.size(); ++i) {
      next.a[i] = scheme_.acceleration(du[i], state_n.v[i], state_n.a[i], dt);
      next.v[i] = scheme_.velocity(next.a[i], state_n.v[i], state_n.a[i], dt);
    }
    const VectorXd y = mean_force_change(state_n, f);
    if (y.size() > 0) {
      next.v += dt * scheme_.step_force_velocity() * y;
      next.a -= scheme_.step_force_acceleration() * y;
    }
    if (model_.damped()) {
      next.damping_work += 0.5 * du.dot(model_.C * (state_n.v + next.v));
    }
  }
  next.external_work += du.dot(0.5 * (state_n.f.end + f.end) + f.step);
  next.f = std::move(f);
  return next;
}

double LinearStep::elastic_energy(const LinearState& state) const {
  return 0.5 * state.u.dot(model_.K * state.u);
}

double LinearStep::kinetic_energy(const LinearState& state) const {
  return dynamic_ ? 0.5 * state.v.dot(model_.M * state.v) : 0;
}

}  // namespace gabion::fem
