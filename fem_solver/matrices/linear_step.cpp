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

/// Check that damping takes energy, or none, in every motion.
/// @throws ConfigError  another one
void require_takes_energy(const LinearModel& model) {
  constexpr double rounding = 1e-9;  // of the diagonal; rigid bodies have zero eigenvalues
  const VectorXd diagonal = model.C.diagonal().cwiseAbs();
  if (diagonal.size() == 0) return;
  const double empty_row = rounding * std::max(diagonal.maxCoeff(), 1e-300);
  SparseMatrix shift(model.C.rows(), model.C.cols());
  shift.setIdentity();
  for (int i = 0; i < diagonal.size(); ++i) {
    shift.coeffRef(i, i) = diagonal[i] > 0 ? rounding * diagonal[i] : empty_row;
  }
  const SymmetricFactor takes_energy(model.C + shift, model.unknowns,
                                     "damping with 1 + 1e-9 times its diagonal");
}

const VectorXd& seen_by_damping(const LinearState& state) {
  return state.v_u.size() > 0 ? state.v_u : state.v;
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
  if (v_u.size() > 0) {
    vector("v_u", v_u);
    vector("a_u", a_u);
  }
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
    if (model_.damped()) require_takes_energy(model_);
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
  if (tracks_displacements()) {
    state.v_u = state.v;
    state.a_u = state.a;
  }
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
  if (tracks_displacements()) state.v_u = state.a_u = zero;
  state.f = {.end = load, .step = zero};
  state.balanced = true;
  return state;
}

SparseMatrix LinearStep::matrix(double dt) const {
  SparseMatrix A = model_.K;
  if (dynamic_) {
    A += scheme_.inertia_slope(dt) * model_.M;
    if (model_.damped()) A += scheme_.gamma / (scheme_.beta * dt) * model_.C;
  }
  return A;
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
  const char* what = dynamic_ ? "stiffness with inertia" : "stiffness";
  factors_.push_front({dt, std::make_unique<SymmetricFactor>(matrix(dt), model_.unknowns, what)});
  ++factorisations_;
  return *factors_.front().factor;
}

/// Factor of (1 - share) M + share A / inertia_slope.
const SymmetricFactor& LinearStep::step_force_factor(double dt) {
  factor(dt);
  KeptFactor& kept = factors_.front();
  if (!kept.of_step_forces) {
    const ScopedTimer timer(times_, "factorisation");
    const double share = implicit_share();
    const SparseMatrix N = (1 - share) * model_.M + share / scheme_.inertia_slope(dt) * matrix(dt);
    kept.of_step_forces = std::make_unique<SymmetricFactor>(N, model_.unknowns, "mass and damping");
    ++factorisations_;
  }
  return *kept.of_step_forces;
}

const VectorXd& LinearStep::start_forces(const LinearState& state_n, double dt) {
  if (start_ && start_->dt == dt) return start_->forces;
  VectorXd f = -(model_.K * state_n.u);
  if (dynamic_) {
    LinearState still;  // what the formulas give where the displacement does not change
    move(state_n, VectorXd::Zero(f.size()), dt, still);
    VectorXd inertia(f.size());
    for (int i = 0; i < f.size(); ++i) inertia[i] = scheme_.inertia(still.a[i], state_n.a[i]);
    f -= model_.M * inertia;
    if (model_.damped()) f -= model_.C * seen_by_damping(still);
    if (const double memory = scheme_.force_memory(); memory > 0) {
      f += memory * (state_n.f.end - model_.K * state_n.u);
      if (model_.damped()) f -= memory * (model_.C * seen_by_damping(state_n));
    }
  }
  start_ = Start{.dt = dt, .forces = std::move(f)};
  return start_->forces;
}

/// Velocities and accelerations by Newmark's formulas.
void LinearStep::move(const LinearState& state_n, const VectorXd& du, double dt,
                      LinearState& next) const {
  const auto follow = [&](const VectorXd& v, const VectorXd& a, VectorXd& v_new, VectorXd& a_new) {
    v_new.resize(v.size());
    a_new.resize(v.size());
    for (int i = 0; i < v.size(); ++i) {
      a_new[i] = scheme_.acceleration(du[i], v[i], a[i], dt);
      v_new[i] = scheme_.velocity(a_new[i], v[i], a[i], dt);
    }
  };
  follow(state_n.v, state_n.a, next.v, next.a);
  follow(state_n.v_u, state_n.a_u, next.v_u, next.a_u);
}

/// M^-1 of the change of the mean forces, or of the matrix that takes its place; empty: they are as
/// in the step before.
VectorXd LinearStep::mean_force_change(const LinearState& state_n, const LinearForces& f,
                                       double dt) {
  if (!dynamic_ || f.step == state_n.f.step) return {};
  const VectorXd change = f.step - state_n.f.step;
  const double share = implicit_share();
  if (share == 0) return mass_->solve(change);
  if (share == 1) return scheme_.inertia_slope(dt) * factor(dt).solve(change);
  return step_force_factor(dt).solve(change);
}

/// Add the part of the mean forces in the balance at the end of the step.
void LinearStep::add_mean_forces(const LinearState& state_n, const LinearForces& f, double dt,
                                 VectorXd& r) {
  const double c = dynamic_ ? scheme_.step_force_weight() : 1;
  if (c == 1 || implicit_share() == 0) {
    r += c * f.step;
    r -= (c - 1) * state_n.f.step;
    return;
  }
  r += f.step;
  const VectorXd y = mean_force_change(state_n, f, dt);
  if (y.size() > 0) r += (c - 1) * (model_.M * y);
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
  VectorXd r = start_forces(state_n, dt) + f.end;
  add_mean_forces(state_n, f, dt, r);
  const ScopedTimer timer(times_, "solve");
  VectorXd u = state_n.u + A.solve(r);
  require_finite(u, dt);
  ++solves_;
  return u;
}

LinearState LinearStep::after(const LinearState& state_n, LinearForces f, VectorXd u, double dt) {
  LinearState next = state_n;
  next.time = state_n.time + dt;
  if (nothing_changes(state_n, f)) return next;
  const VectorXd du = u - state_n.u;
  next.u = std::move(u);
  next.balanced = true;
  if (dynamic_) {
    move(state_n, du, dt, next);
    const VectorXd y = mean_force_change(state_n, f, dt);
    if (y.size() > 0) {
      next.v += dt * scheme_.step_force_velocity() * y;
      next.a -= scheme_.step_force_acceleration() * y;
    }
    if (model_.damped()) next.damping_work += du.dot(model_.C * du) / dt;
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
