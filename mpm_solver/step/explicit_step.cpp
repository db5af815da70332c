// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step/explicit_step.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/checks/pools.hpp"
#include "mpm_solver/points/flat.hpp"

namespace gabion::mpm {

namespace {

// Largest number of substeps: a step that needs more is a mistake in the settings or in the
// solution.
constexpr double most_substeps = 1e5;

// A quotient of times within this of a whole number counts as that number.
constexpr double rounding = 1e-9;

// Changes of the substep by less are not worth a line in the log.
constexpr double notable_change = 0.2;

// Weight and other body forces at a share of the step.
template <int dim>
std::vector<double> body_forces(const GridNodes<dim>& nodes, const Vector<dim>& gravity,
                                std::span<const double> f_start, std::span<const double> f_end,
                                double share) {
  std::vector<double> f(nodes.m.size() * dim);
  for (std::size_t k = 0; k < f.size(); ++k) {
    f[k] = nodes.m[k / dim] * gravity[static_cast<Eigen::Index>(k % dim)];
    if (!f_end.empty()) f[k] += (1 - share) * f_start[k] + share * f_end[k];
  }
  return f;
}

}  // namespace

template <int dim>
ExplicitStep<dim>::ExplicitStep(const Parts& parts) : parts_(parts), stable_(parts.model) {
  if (!parts.model.drains || !any_explicit(parts.model.settings.phases)) return;
  require<ConfigError>(
      num_ranks(parts.model.comm) == 1,
      "mpm.json: at /bodies: found \"permeability\" with explicit steps on {} ranks, "
      "allowed: one rank; the pressures of a substep are found on one",
      num_ranks(parts.model.comm));
  borders_.emplace(parts.model);
}

// The data on which the pore water of the step depends.
template <int dim>
void ExplicitStep<dim>::find_water() {
  water_.reset();
  if (!borders_) return;
  const SoilModel<dim>& model = parts_.model;
  const double end = start_.time + start_.dt;
  const Vector<dim> gravity =
      model.settings.phases[start_.phase].gravity_ramp.at(end) * model.settings.gravity;
  const PoolLevels pools = pool_levels<dim>(model.settings, end, gravity);
  water_.emplace(WaterOfStep<dim>{
      .data = {.gravity = gravity,
               .cell_size = model.cell_size,
               .averages = model.settings.locking.average_volumes,
               .pools = pools,
               .rain = borders_->rain_at(end)},
      .surface = borders_->open() ? borders_->free_surface(parts_.state, start_.phase)
                                  : std::vector<OuterPoint<dim>>(),
      .drained = borders_->drained_nodes(
          nodes(), {.phase = start_.phase, .time = end, .gravity = gravity, .pools = pools})});
}

template <int dim>
void ExplicitStep<dim>::begin(const StepStart& start) {
  start_ = start;
  find_water();
  f_body_start_ = parts_.soil.body_forces(start.time);
  f_body_ = parts_.soil.body_forces(start.time + start.dt);
  const ScopedTimer timer(parts_.times, "substeps");
  const SoilModel<dim>& model = parts_.model;
  const Phase& phase = model.settings.phases[start.phase];
  courant_ = *phase.courant;
  const auto body_force = [this, &model, ramp = phase.gravity_ramp](double share) {
    const Vector<dim> gravity = ramp.at(start_.time + share * start_.dt) * model.settings.gravity;
    return body_forces<dim>(nodes(), gravity, f_body_start_, f_body_, share);
  };
  motion_.emplace(
      typename ExplicitMotion<dim>::Parts{.stress = {.bodies = model.settings.bodies,
                                                     .points = parts_.state.points,
                                                     .weights = parts_.soil.weights(),
                                                     .nodes = nodes(),
                                                     .trial = parts_.trial,
                                                     .held_normal = walls().held_normal(),
                                                     .laws = parts_.soil.laws().of_points()},
                                          .grid = model.grid,
                                          .averages = model.settings.softening_averages,
                                          .walls = walls(),
                                          .surfaces = parts_.state.surfaces,
                                          .cell_size = model.cell_size,
                                          .dt = start.dt,
                                          .average_volumes = model.settings.locking.average_volumes,
                                          .largest_courant = std::max(1.0, courant_),
                                          .body_force = body_force,
                                          .water = water_ ? &*water_ : nullptr});
  repeated_ = std::exchange(repeats_, false);
  // No step with boulders or groups of bodies repeats a part alone: boulders move as interfaces do,
  // and soil that an interface moves may push another body.
  may_repeat_ = !model.settings.whole_iterations && model.settings.boulders.empty() &&
                !model.settings.body_groups.any() && !model.remembers_variables && !water_ &&
                parts_.state.surfaces.may_touch_interface();
  soil_dt_ = stable_.of_soil(parts_.state.points);
  count_ = count_for(start.dt, parts_.state.contact_rate);
}

template <int dim>
int ExplicitStep<dim>::count_for(double dt, double contact_rate) const {
  const double count = std::sqrt(squared_courant(dt, soil_dt_, contact_rate)) / courant_;
  if (!(count <= most_substeps)) {
    throw ConvergenceError(
        fmt::format("explicit step of {:.4g} s: {:.3g} substeps would be stable, allowed: {:g}", dt,
                    count, most_substeps),
        "substeps");
  }
  return std::max(1, static_cast<int>(std::ceil(count * (1 - rounding))));
}

template <int dim>
StepReport ExplicitStep<dim>::solve(const StepRequest& request) {
  const ScopedTimer timer(parts_.times, "substeps");
  if (request.iteration > 0) repeats_ = true;
  const bool repeats = may_repeat_ && (repeats_ || repeated_);
  while (!motion_->solve(count_, soil_dt_, repeats)) {
    counts_.substeps += count_;
    count_ = std::max(count_ + 1, count_for(start_.dt, motion_->result().contact_rate));
  }
  ++counts_.solutions;
  counts_.substeps += count_;
  counts_.largest = std::max(counts_.largest, count_);
  if (motion_->water() != nullptr) counts_.pressure_iterations += motion_->water()->iterations();
  if (request.iteration > 0) add_repeated();
  const double dt = start_.dt / count_;
  if (counts_.smallest == 0 || dt < counts_.smallest) counts_.smallest = dt;
  log_count(request);
  return {};
}

template <int dim>
void ExplicitStep<dim>::add_repeated() {
  const auto& found = motion_->result();
  ++counts_.repeated;
  if (!found.within_reach) ++counts_.repeated_whole;
  counts_.repeated_points += std::int64_t{count_} * parts_.state.points.size();
  counts_.evaluated_points += found.evaluated;
}

template <int dim>
void ExplicitStep<dim>::log_count(const StepRequest& request) {
  const double dt = start_.dt / count_;
  if (std::abs(dt - logged_dt_) <= notable_change * logged_dt_) return;
  logged_dt_ = dt;
  log::info("{:.6g} s: explicit: {} {} of {:.3g} s", request.time, count_,
            count_ == 1 ? "substep" : "substeps", dt);
}

template <int dim>
NodalMotion<dim> ExplicitStep<dim>::nodal_motion() const {
  const auto& found = motion_->result();
  const auto& v_start = motion_->start_velocity();
  NodalMotion<dim> motion;
  for (std::int32_t i = 0; i < nodes().size(); ++i) {
    const auto at = [i](const std::vector<double>& field) {
      return Vector<dim>(Eigen::Map<const Vector<dim>>(field.data() + std::ptrdiff_t{i} * dim));
    };
    motion.du.push_back(at(found.du));
    motion.v_new.push_back(motion_->inertia().is_weightless(i)
                               ? at(found.v)
                               : Vector<dim>(at(v_start) + at(found.impulse) / nodes().m[i]));
    motion.a_new.push_back(at(found.a));
  }
  return motion;
}

// The points get the energy v . M d + d . M S d / 2 + I . (v + S d + W I / 2), S = W M. It comes
// from the walls, which change v by d = Q v - v, and from the impulse I, of which the forces gave I
// . (Q v + W I / 2).
template <int dim>
StepBalance<dim> ExplicitStep<dim>::balance() const {
  const auto& found = motion_->result();
  const auto& v_start = motion_->start_velocity();
  StepBalance<dim> step;
  std::vector<double> held = found.wall_force, free = found.wall_force;
  walls().project(free);
  std::vector<double> stop(v_start.size()), mapped(v_start.size());  // M d, S d
  for (std::size_t k = 0; k < stop.size(); ++k) {
    stop[k] = nodes().m[k / dim] * (v_start[k] - nodes().v[k / dim][k % dim]);
  }
  motion_->inertia().apply(stop, mapped);
  double gained = 0;
  for (std::int32_t i = 0; i < nodes().size(); ++i) {
    if (!nodes().shared.owns(i)) continue;
    for (int d = 0; d < dim; ++d) {
      const std::size_t k = static_cast<std::size_t>(i) * dim + d;
      const double v = nodes().v[i][d], d_v = v_start[k] - v;
      step.kinetic_before += 0.5 * nodes().m[i] * v * v;
      step.wall_loss += found.impulse[k] * (d_v - mapped[k]) - stop[k] * (v + 0.5 * mapped[k]);
      gained += found.impulse[k] * 0.5 * (v_start[k] + found.v[k]);
      step.wall_kick[d] += stop[k];
      step.wall_force[d] -= held[k] - free[k];
    }
  }
  step.kinetic_after = step.kinetic_before - step.wall_loss + gained;
  step.body_work = found.body_work;
  step.boundary_work = found.contact_work + found.wall_work;
  step.time_damping = found.body_work + step.boundary_work - found.internal_work - gained;
  step.body_force = found.body_impulse / start_.dt;
  step.step_force = found.contact_impulse / start_.dt;
  sum_parts(parts_.model.comm, step);
  return step;
}

template <int dim>
StepEnd<dim> ExplicitStep<dim>::end() {
  StepEnd<dim> end;
  end.motion = nodal_motion();
  end.balance = balance();
  end.plastic_work = motion_->result().plastic_work;
  if (FractionalStep<dim>* water = motion_->water()) {
    end.plastic_work += water->finish() + water->water().weight_work() + water->supplied_work();
    end.balance.body_work += water->water().weight_work();
    end.balance.boundary_work += water->supplied_work();
    end.balance.step_force += water->pool_impulse() / start_.dt;
  }
  return end;
}

template <int dim>
std::vector<Vector<dim>> ExplicitStep<dim>::wall_forces() const {
  std::vector<Vector<dim>> forces = walls().forces(motion_->result().wall_force, nodes().shared);
  nodes().shared.total(flat(forces));
  return forces;
}

template <int dim>
void ExplicitStep<dim>::finish_points(MaterialPoints<dim>& points) const {
  motion_->inertia().kick_from_weightless(motion_->result().impulse,
                                          1 - parts_.model.settings.pic_share, points);
  if (motion_->water() != nullptr) motion_->water()->water().store(points);
}

template <int dim>
void ExplicitStep<dim>::remember(SoilState<dim>& state) const {
  state.nearly_linear = false;
  state.contact_rate = motion_->result().contact_rate;
  if (motion_->water() == nullptr) return;
  const FractionalStep<dim>& water = *motion_->water();
  state.water_out += water.outflow();
  state.rain_in += water.rain_in();
  state.rain_run_off += water.rain_run_off();
}

template class ExplicitStep<2>;
template class ExplicitStep<3>;

}  // namespace gabion::mpm
