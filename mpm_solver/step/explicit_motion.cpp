// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step/explicit_motion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/error.hpp"
#include "mpm_solver/step/stable_step.hpp"

namespace gabion::mpm {

template <int dim>
ExplicitMotion<dim>::ExplicitMotion(const Parts& parts)
    : parts_(parts),
      inertia_(parts.stress.points, parts.stress.weights, parts.stress.nodes),
      internal_(with_path(), parts.cell_size, 0, parts.average_volumes),
      may_touch_(!parts.surfaces.contacts().empty()) {
  const GridNodes<dim>& nodes = parts_.stress.nodes;
  for (const Vector<dim>& v : nodes.v) v_start_.insert(v_start_.end(), v.begin(), v.end());
  parts_.walls.impose(v_start_, 1 / parts_.dt);
  start_.body = parts_.body_force(0);
  start_.internal = internal_.start_forces();
  nodes.shared.sum(start_.internal, dim);
  set_acceleration(start_);
  F_.resize(v_start_.size());
  A_F_.resize(v_start_.size());
  if (may_touch_) find_lasting();
  if (parts_.water == nullptr) return;
  water_ = std::make_unique<FractionalStep<dim>>(
      typename FractionalStep<dim>::Parts{parts_.stress, *parts_.water, parts_.walls, inertia_});
}

template <int dim>
const StressParts<dim>& ExplicitMotion<dim>::with_path() {
  parts_.stress.path = &path_;
  context_.grid = &parts_.grid;
  context_.averages = parts_.averages;
  parts_.stress.context = &context_;
  parts_.stress.kept = &kept_;
  return parts_.stress;
}

// A = Q W Q f.
template <int dim>
void ExplicitMotion<dim>::respond(std::span<const double> f, std::vector<double>& A) const {
  std::vector<double> free(f.begin(), f.end());
  parts_.walls.project(free);
  A.resize(f.size());
  inertia_.apply(free, A);
  parts_.walls.project(A);
}

template <int dim>
void ExplicitMotion<dim>::set_acceleration(Forces& forces) const {
  std::vector<double> f = forces.body;
  for (std::size_t k = 0; k < f.size(); ++k) f[k] -= forces.internal[k];
  respond(f, forces.A);
}

template <int dim>
void ExplicitMotion<dim>::set_acceleration_within(int k, Forces& forces) const {
  std::vector<double> f = forces.body;
  for (std::size_t i = 0; i < f.size(); ++i) f[i] -= forces.internal[i];
  parts_.walls.project(f);
  forces.A.resize(f.size());
  inertia_.apply_to(reach_->responding_groups(k), f, forces.A);
  parts_.walls.project(forces.A);
  reach_->fill_A(k, forces.A);
}

template <int dim>
void ExplicitMotion<dim>::find_lasting() {
  const SharedNodes& shared = parts_.stress.nodes.shared;
  std::vector<double> lasting(v_start_.size(), 0.0);
  for (const auto& contact : parts_.surfaces.contacts())
    contact->substeps().add_lasting_forces(lasting);
  const bool own = std::any_of(lasting.begin(), lasting.end(), [](double f) { return f != 0; });
  if (shared.all(!own)) return;
  shared.sum(lasting, dim);
  respond(lasting, A_lasting_);
}

// Evaluate the contacts at u, the end of a substep with the lasting force alone; sets F, A(F),
// touches_.
// @returns false: too stiff for dt
template <int dim>
bool ExplicitMotion<dim>::add_contact(std::span<const double> u, double share, double dt,
                                      double soil_dt) {
  if (!may_touch_) return true;
  const SharedNodes& shared = parts_.stress.nodes.shared;
  std::fill(F_.begin(), F_.end(), 0.0);
  for (const auto& contact : parts_.surfaces.contacts()) {
    contact->substeps().set_share(share);
    contact->assembly().add_forces(u, F_, nullptr);
  }
  const bool own = std::any_of(F_.begin(), F_.end(), [](double f) { return f != 0; });
  touches_ = !shared.all(!own);
  if (!touches_) return true;
  shared.sum(F_, dim);
  respond(F_, A_F_);
  std::vector<double> row_sums(F_.size() / dim, 0.0);
  for (const auto& contact : parts_.surfaces.contacts())
    contact->substeps().add_stiffness_sums(row_sums);
  shared.sum(row_sums, 1);
  result_.contact_rate = std::max(result_.contact_rate, inertia_.largest_rate(row_sums));
  return squared_courant(dt, soil_dt, result_.contact_rate) <= std::pow(parts_.largest_courant, 2);
}

// A single substep is the whole step.
template <int dim>
void ExplicitMotion<dim>::begin_path(int count) {
  const MaterialPoints<dim>& points = parts_.stress.points;
  path_ = {};
  tau_.clear();
  const bool elastic = std::ranges::all_of(
      parts_.stress.bodies, [](const Body<dim>& body) { return is_elastic(body.material.law); });
  if (elastic) return;
  std::vector<Symmetric<dim>> room;
  const auto tau = skeleton_stresses<dim>(parts_.stress.bodies, points, room);
  tau_.assign(tau.begin(), tau.end());
  if (count > 1) {
    path_ = {.history = points.history,
             .internal = points.internal,
             .variables = points.variables,
             .F = std::vector<Matrix<dim>>(points.variables.size(), Matrix<dim>::Identity())};
  }
  internal_.forget();
}

// Continue after the stresses of a substep: its dissipation is summed in the order of the entries.
template <int dim>
void ExplicitMotion<dim>::advance_path(int k) {
  if (tau_.empty()) return;
  const StressParts<dim>& parts = parts_.stress;
  const auto& weights = parts.weights;
  const auto advance = [&](std::int32_t first, std::int32_t last) {
    for (std::int32_t e = first; e < last; ++e) {
      Symmetric<dim>& tau = tau_[weights.point[e]];
      plastic_[e] = plastic_density(parts.trial, e, tau);
      tau = parts.trial.effective_tau(e);
    }
  };
  if (within_) {
    plastic_ = reach_->known(k).plastic;
    for (const auto& [first, last] : reach_->part(k).ranges) {
      advance(weights.groups[first].first, weights.groups[last - 1].last);
    }
  } else {
    plastic_.resize(weights.volume.size());
    advance(0, parts.points.size());
  }
  double work = 0;
  for (std::int32_t e = 0; e < parts.points.size(); ++e) work += weights.volume[e] * plastic_[e];
  result_.plastic_work += work;
}

template <int dim>
void ExplicitMotion<dim>::find_reach() {
  std::vector<char> touched(static_cast<std::size_t>(parts_.stress.nodes.size()), 0);
  if (touches_) parts_.surfaces.mark_touched(touched);
  reach_->find(F_, touched);
  if (reach_->keeps()) {
    reach_->keep_states(path_, tau_);
    reach_->ask_for_forces(kept_);
  } else {
    kept_ = {};
  }
}

// Evaluate stresses and internal forces of this rank's points at result_.du.
template <int dim>
bool ExplicitMotion<dim>::evaluate(int k, RefusedPoint& worst) {
  if (!within_) {
    result_.evaluated += parts_.stress.points.size();
    return internal_.evaluate(result_.du, nullptr, worst);
  }
  result_.evaluated += reach_->num_points(k);
  reach_->load_states(k, path_, tau_);
  return internal_.evaluate_part(result_.du, reach_->part(k), worst);
}

// Forces of the soil at result_.du.
template <int dim>
typename ExplicitMotion<dim>::Forces ExplicitMotion<dim>::forces_at(const Substep& substep) {
  const SharedNodes& shared = parts_.stress.nodes.shared;
  RefusedPoint worst;
  const bool admissible = evaluate(substep.k, worst);
  if (!shared.all(admissible)) {
    const std::string own =
        worst.point < 0 ? ""
                        : fmt::format("material point {} {}", parts_.stress.points.id[worst.point],
                                      refusal_text(worst.refusal));
    throw ConvergenceError("explicit step: " + shared.first_text(own), "inadmissible");
  }
  Forces forces{
      .body = parts_.body_force(substep.share()), .internal = internal_.forces(), .A = {}};
  shared.sum(forces.internal, dim);
  if (water_) {
    for (std::size_t i = 0; i < forces.internal.size(); ++i) {
      forces.internal[i] -= water_->forces()[i];
    }
  }
  if (within_) {
    reach_->fill_internal(substep.k, forces.internal);
    set_acceleration_within(substep.k, forces);
  } else {
    set_acceleration(forces);
  }
  advance_path(substep.k);
  return forces;
}

// Keep the displacement, forces and stresses for the solutions after this one.
template <int dim>
void ExplicitMotion<dim>::keep(const Forces& forces) {
  reach_->keep({.du = result_.du,
                .internal = forces.internal,
                .A = forces.A,
                .plastic = tau_.empty() ? std::vector<double>() : plastic_},
               std::move(kept_.values));
  kept_ = {};
}

template <int dim>
void ExplicitMotion<dim>::add_works(std::span<const double> move, const Forces& before,
                                    const Forces& after, double dt) {
  const GridNodes<dim>& nodes = parts_.stress.nodes;
  std::vector<double> total(move.size()), held;
  for (std::int32_t i = 0; i < nodes.size(); ++i) {
    const bool counts = nodes.shared.owns(i);
    for (int d = 0; d < dim; ++d) {
      const std::size_t k = static_cast<std::size_t>(i) * dim + d;
      const double body = 0.5 * (before.body[k] + after.body[k]);
      const double internal = 0.5 * (before.internal[k] + after.internal[k]);
      const double contact = touches_ ? F_[k] : 0;
      total[k] = body - internal + contact;
      if (water_) total[k] += water_->change()[k];
      raw_[k] += dt * total[k];
      if (!counts) continue;
      result_.body_work += move[k] * body;
      result_.internal_work += move[k] * internal;
      if (water_) result_.internal_work -= move[k] * water_->change()[k];
      result_.contact_work += move[k] * contact;
      result_.body_impulse[d] += dt * body;
      result_.contact_impulse[d] += dt * contact;
    }
  }
  if (!parts_.walls.move()) return;
  held = total;
  parts_.walls.project(held);
  for (std::int32_t i = 0; i < nodes.size(); ++i) {
    for (int d = 0; d < dim && nodes.shared.owns(i); ++d) {
      const std::size_t k = static_cast<std::size_t>(i) * dim + d;
      result_.wall_work -= move[k] * (total[k] - held[k]);
    }
  }
}

template <int dim>
bool ExplicitMotion<dim>::solve(int count, double soil_dt, bool repeats) {
  const bool suits = !parts_.stress.weights.constant_gradient;
  if (repeats && suits && !reach_) reach_.emplace(parts_.stress);
  within_ = reach_ && reach_->knows(count);
  Outcome outcome = run(count, soil_dt);
  if (outcome == Outcome::beyond_reach) {
    within_ = false;
    outcome = run(count, soil_dt);
  }
  result_.within_reach = within_;
  return outcome == Outcome::solved;
}

template <int dim>
typename ExplicitMotion<dim>::Outcome ExplicitMotion<dim>::run(int count, double soil_dt) {
  const std::size_t n = v_start_.size();
  result_ = {};
  result_.du.assign(n, 0.0);
  result_.v = v_start_;
  raw_.assign(n, 0.0);
  kept_ = {};
  context_.dt = parts_.dt / count;
  if (water_) water_->begin(context_.dt);
  if (!within_) begin_path(count);
  if (reach_ && !within_) reach_->begin(count);
  for (const auto& contact : parts_.surfaces.contacts()) contact->substeps().begin_substeps();
  Forces before = start_;
  if (water_ && water_->subtract_pools(before.internal)) set_acceleration(before);
  for (int k = 0; k < count; ++k) {
    const Outcome outcome = do_substep({k, count}, soil_dt, before);
    if (outcome != Outcome::solved) return outcome;
  }
  finish(before);
  if (reach_ && !within_) reach_->complete();
  return Outcome::solved;
}

// @param before  forces at the start of the substep; becomes those at its end
template <int dim>
typename ExplicitMotion<dim>::Outcome ExplicitMotion<dim>::do_substep(const Substep& substep,
                                                                      double soil_dt,
                                                                      Forces& before) {
  const std::size_t n = v_start_.size();
  const double dt = substep.dt(parts_.dt);
  star_.resize(n);
  move_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    star_[i] = result_.du[i] + dt * (result_.v[i] + 0.5 * dt * before.A[i]);
  }
  if (!A_lasting_.empty()) foreseen_ = star_;
  for (std::size_t i = 0; i < A_lasting_.size(); ++i) {
    foreseen_[i] += 0.5 * dt * dt * A_lasting_[i];
  }
  touches_ = false;
  if (!add_contact(A_lasting_.empty() ? star_ : foreseen_, substep.share(), dt, soil_dt)) {
    return Outcome::too_stiff;
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (touches_) star_[i] += 0.5 * dt * dt * A_F_[i];
  }
  if (water_) water_->solve(star_);
  for (std::size_t i = 0; i < n; ++i) {
    move_[i] = star_[i] - result_.du[i];
    result_.du[i] = star_[i];
  }
  if (within_ && !parts_.stress.nodes.shared.all(reach_->covers(substep.k, result_.du))) {
    return Outcome::beyond_reach;
  }
  if (touches_) {
    for (const auto& contact : parts_.surfaces.contacts()) {
      contact->substeps().add_substep(move_, 1. / substep.count);
    }
  }
  const bool keeps = reach_ && !within_ && reach_->keeps();
  if (keeps) find_reach();
  Forces after = forces_at(substep);
  if (keeps && reach_->keeps()) keep(after);
  for (std::size_t i = 0; i < n; ++i) {
    result_.v[i] += 0.5 * dt * (before.A[i] + after.A[i]) + (touches_ ? dt * A_F_[i] : 0);
    if (water_) result_.v[i] += dt * water_->acceleration()[i];
  }
  add_works(move_, before, after, dt);
  if (water_) water_->end_substep(move_);
  before = std::move(after);
  return Outcome::solved;
}

template <int dim>
void ExplicitMotion<dim>::finish(const Forces& last) {
  const GridNodes<dim>& nodes = parts_.stress.nodes;
  double sum = 0;
  for (const double v : result_.v) sum += v;
  if (!nodes.shared.all(std::isfinite(sum))) {
    throw ConvergenceError("explicit step: velocities are not finite", "not_finite");
  }
  // The contact points are found at the end of the step, for the memory of the surfaces.
  for (const auto& contact : parts_.surfaces.contacts()) {
    contact->assembly().add_forces(result_.du, F_, nullptr);
  }
  result_.impulse = raw_;
  parts_.walls.project(result_.impulse);
  result_.wall_force = raw_;
  for (double& f : result_.wall_force) f /= parts_.dt;
  result_.a.assign(raw_.size(), 0.0);
  for (std::size_t k = 0; k < raw_.size(); ++k) {
    const auto i = static_cast<std::int32_t>(k / dim);
    if (inertia_.is_weightless(i)) continue;
    result_.a[k] = (last.body[k] - last.internal[k]) / nodes.m[i];
  }
  parts_.walls.project(result_.a);
}

template class ExplicitMotion<2>;
template class ExplicitMotion<3>;

}  // namespace gabion::mpm
