// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step/equilibrium.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/require.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "common/mechanics/ranks/text.hpp"
#include "mpm_solver/points/flat.hpp"
#include "mpm_solver/stress/point_motion.hpp"

namespace gabion::mpm {

namespace {

// A node that points hardly weigh on gets this share of the mean nodal mass: without it the matrix
// is singular there once the soil around it has no stiffness. Small enough to be far below the
// error of the scheme, large enough for double precision.
constexpr double mass_floor = 1e-8;

// Ratio of the support's stiffness to the mean stiffness of a node.
constexpr double support_share = 1e-4;

// Share of the force that would stop a node within the step: the residual is compared with it too,
// since soil that flies freely has no other force.
constexpr double share_of_stopping = 1e-3;

}  // namespace

template <int dim>
Equilibrium<dim>::Equilibrium(const Parts& parts)
    : parts_(parts),
      context_{.dt = parts.dt, .grid = &parts.grid, .averages = parts.averages},
      internal_({.bodies = parts.bodies,
                 .points = parts.points,
                 .weights = parts.weights,
                 .nodes = parts.nodes,
                 .trial = parts.trial,
                 .context = &context_,
                 .held_normal = parts.walls.held_normal(),
                 .laws = parts.laws},
                parts.cell_size, parts.same_strain, parts.average_volumes, parts.repeats),
      m_(parts.nodes.m) {
  const auto& nodes = parts_.nodes;
  if (parts_.with_inertia) {
    const auto count = static_cast<double>(std::max<std::int64_t>(1, nodes.num_of_all()));
    const double floor = mass_floor * total_mass(nodes) / count;
    for (double& mass : m_) mass = std::max(mass, floor);
  }
  v_.assign(nodes.v.empty() ? nullptr : nodes.v.front().data(),
            nodes.v.empty() ? nullptr : nodes.v.front().data() + nodes.v.size() * dim);
  a_.assign(nodes.a.empty() ? nullptr : nodes.a.front().data(),
            nodes.a.empty() ? nullptr : nodes.a.front().data() + nodes.a.size() * dim);
  parts_.walls.impose(v_, 1 / parts_.dt);
  parts_.walls.project(a_);
  if (parts_.scheme.force_memory() != 0) remember_start_forces();
}

template <int dim>
void Equilibrium<dim>::remember_start_forces() {
  require(parts_.contacts.empty(), "mpm_solver: averaged forces at an interface");
  f_start_ = internal_.start_forces();
  shared().sum(f_start_, dim);
  const double memory = parts_.scheme.force_memory();
  for (std::size_t k = 0; k < f_start_.size(); ++k) {
    double f_ext = m_[k / dim] * parts_.gravity_start[k % dim];
    if (!parts_.f_body_start.empty()) f_ext += parts_.f_body_start[k];
    f_start_[k] = memory * (f_ext - f_start_[k]);
  }
}

template <int dim>
std::vector<double> Equilibrium<dim>::step_force_change() const {
  const auto& contacts = parts_.contacts;
  if (std::none_of(contacts.begin(), contacts.end(),
                   [](const auto& contact) { return contact->assembly().is_step_force(); })) {
    return {};
  }
  std::vector<double> change(r_before_walls_.size(), 0.0);
  for (const auto& contact : contacts) contact->assembly().add_step_force_change(change);
  shared().sum(change, dim);
  return change;
}

template <int dim>
std::vector<Vector<dim>> Equilibrium<dim>::wall_forces() const {
  const std::vector<double> change = step_force_change();
  std::vector<double> r = r_before_walls_;
  const double extra = parts_.with_inertia ? parts_.scheme.step_force_weight() - 1 : 0;
  for (std::size_t k = 0; k < change.size(); ++k) r[k] -= extra * change[k];
  std::vector<Vector<dim>> forces = parts_.walls.forces(r, shared());
  shared().total(flat(forces));
  return forces;
}

template <int dim>
void Equilibrium<dim>::pattern(std::vector<std::int32_t>& offsets,
                               std::vector<std::int32_t>& cell_nodes) const {
  offsets.assign(1, 0);
  cell_nodes.clear();
  for (const CellGroup& group : parts_.weights.groups) {
    for (const std::int32_t node : parts_.weights.nodes_of(group)) {
      cell_nodes.push_back(parts_.nodes.active[node]);
    }
    offsets.push_back(static_cast<std::int32_t>(cell_nodes.size()));
  }
  for (const auto& contact : parts_.contacts) contact->assembly().append_cells(offsets, cell_nodes);
  if (parts_.ghost != nullptr) parts_.ghost->append_cells(offsets, cell_nodes);
}

template <int dim>
Evaluation Equilibrium<dim>::evaluate(std::span<const double> du, std::span<double> r,
                                      BlockMatrix<dim>* K) {
  RefusedPoint worst;
  Sums sums;
  sums.inadmissible = internal_.evaluate(du, K, worst) ? 0 : 1;
  if (K && regularisation_ > 0) internal_.add_regularisation(regularisation_, *K);
  sum_forces(du, r, K);
  add_weight(r, sums);
  if (parts_.with_inertia) add_inertia(du, r, K, sums);
  for (std::size_t k = 0; k < r.size(); ++k) r[k] -= f_sum_[k];
  for (std::size_t k = 0; k < f_start_.size(); ++k) r[k] += f_start_[k];
  r_before_walls_.assign(r.begin(), r.end());
  if (K && !wall_step_.empty()) subtract_wall_step(*K, r);
  parts_.walls.project(r);
  if (K) {
    K->constrain(parts_.walls.constrained(), parts_.walls.projectors(),
                 [this](std::int32_t i) { return shared().owns(i); });
  }
  sums.internal = shared().own_dot(f_sum_, f_sum_);
  sums.residual = shared().own_dot(r, r);
  return assess(sums, worst);
}

template <int dim>
Evaluation Equilibrium<dim>::assess(Sums sums, const RefusedPoint& worst) {
  sums.neighbours = internal_.neighbours_matrix() ? 1 : 0;
  double* const all[] = {&sums.internal, &sums.external,     &sums.inertial,  &sums.stopping,
                         &sums.residual, &sums.inadmissible, &sums.neighbours};
  std::array<double, std::size(all)> values;
  for (std::size_t k = 0; k < values.size(); ++k) values[k] = *all[k];
  shared().total(values);
  for (std::size_t k = 0; k < values.size(); ++k) *all[k] = values[k];
  Evaluation result;
  result.likely_last = first_evaluation_ && (parts_.nearly_linear || sums.neighbours > 0);
  if (sums.inadmissible > 0) {
    result.admissible = false;
    result.reason =
        shared().first_text(worst.point < 0 ? ""
                                            : fmt::format("{} {}", describe_point(worst.point),
                                                          refusal_text(worst.refusal)));
    return result;
  }
  first_evaluation_ = false;
  result.residual_norm = std::sqrt(sums.residual);
  result.force_scale =
      std::sqrt(std::max({sums.internal, sums.external, sums.inertial, sums.stopping}));
  result.admissible = std::isfinite(result.force_scale) && std::isfinite(*result.residual_norm);
  if (!result.admissible) result.reason = "forces are not finite";
  return result;
}

// Evaluate the internal forces, and add those of contacts and small cuts to r.
template <int dim>
void Equilibrium<dim>::sum_forces(std::span<const double> du, std::span<double> r,
                                  BlockMatrix<dim>* K) {
  f_sum_ = internal_.forces();
  for (std::size_t k = 0; k < parts_.f_pore.size(); ++k) f_sum_[k] -= parts_.f_pore[k];
  std::fill(r.begin(), r.end(), 0.0);
  for (const auto& contact : parts_.contacts) contact->assembly().add_forces(du, r, K);
  if (parts_.ghost != nullptr) parts_.ghost->add_forces(du, r, K);
  if (K && supported_) {
    const double support = support_share * K->mean_diagonal();
    for (std::int32_t i = 0; i < K->num_nodes(); ++i) {
      if (shared().owns(i)) K->add_diagonal(i, support);
    }
  }
  if (parts_.contacts.empty() && parts_.ghost == nullptr) {
    shared().sum(f_sum_, dim);
  } else {
    shared().sum(f_sum_, r, dim);
  }
}

template <int dim>
bool Equilibrium<dim>::regularise(double share) {
  regularisation_ = share;
  return max_over_ranks(parts_.comm, internal_.yielded() ? 1 : 0) > 0;
}

template <int dim>
bool Equilibrium<dim>::support(bool on) {
  const bool may_be_loose = !parts_.with_inertia && !parts_.contacts.empty();
  supported_ = on && may_be_loose;
  return may_be_loose;
}

template <int dim>
Evaluation Equilibrium<dim>::linearise(std::span<const double> wall_step, std::span<double> r,
                                       BlockMatrix<dim>& K) {
  const std::vector<double> still(wall_step.size(), 0.0);
  wall_step_ = wall_step;
  const Evaluation result = evaluate(still, r, &K);
  wall_step_ = {};
  return result;
}

template <int dim>
void Equilibrium<dim>::subtract_wall_step(const BlockMatrix<dim>& K, std::span<double> r) const {
  std::vector<double> f(r.size(), 0.0);
  K.multiply(wall_step_, f);
  shared().sum(f, dim);
  for (std::size_t k = 0; k < r.size(); ++k) r[k] -= f[k];
}

// Add f_ext to r.
template <int dim>
void Equilibrium<dim>::add_weight(std::span<double> r, Sums& sums) const {
  for (std::int32_t i = 0; i < parts_.nodes.size(); ++i) {
    const bool counts = shared().owns(i);
    for (int d = 0; d < dim; ++d) {
      const std::size_t k = static_cast<std::size_t>(i) * dim + d;
      const double f_ext =
          m_[i] * parts_.gravity[d] + (parts_.f_body.empty() ? 0 : parts_.f_body[k]);
      r[k] += f_ext;
      if (counts) sums.external += f_ext * f_ext;
    }
  }
}

// Add -f_inertia to r and its slope to K.
template <int dim>
void Equilibrium<dim>::add_inertia(std::span<const double> du, std::span<double> r,
                                   BlockMatrix<dim>* K, Sums& sums) const {
  const double dt = parts_.dt;
  const NewmarkBossak scheme = parts_.scheme;
  const double slope = scheme.inertia_slope(dt), stop = share_of_stopping / dt;
  // The inertia is linear in du, v and a.
  const double by_v = scheme.inertia(scheme.acceleration(0, 1, 0, dt), 0);
  const double by_a = scheme.inertia(scheme.acceleration(0, 0, 1, dt), 1);
  for (std::int32_t i = 0; i < parts_.nodes.size(); ++i) {
    const double mass = m_[i];
    double inertial = 0, stopping = 0;
    for (int d = 0; d < dim; ++d) {
      const std::size_t k = static_cast<std::size_t>(i) * dim + d;
      const double f_inertia = mass * (slope * du[k] + by_v * v_[k] + by_a * a_[k]);
      const double f_stop = stop * mass * v_[k];
      r[k] -= f_inertia;
      inertial += f_inertia * f_inertia;
      stopping += f_stop * f_stop;
    }
    if (!shared().owns(i)) continue;
    sums.inertial += inertial;
    sums.stopping += stopping;
    if (K) K->add_diagonal(i, mass * slope);
  }
}

template <int dim>
std::string Equilibrium<dim>::describe_node(std::size_t i) const {
  const std::int32_t node = parts_.nodes.place(static_cast<std::int32_t>(i));
  const Vector<dim> x = parts_.grid.node(node);
  return fmt::format("grid node {} at ({:.4g})", node, fmt::join(x.data(), x.data() + dim, ", "));
}

template <int dim>
std::string Equilibrium<dim>::describe_point(std::int32_t p) const {
  const auto& points = parts_.points;
  const auto next = std::upper_bound(points.body_starts.begin(), points.body_starts.end(), p);
  const auto body = static_cast<std::size_t>(next - points.body_starts.begin() - 1);
  const Vector<dim>& x = points.x[p];
  return fmt::format("material point {} of \"{}\" at ({:.4g})", points.id[p],
                     parts_.bodies[body].name, fmt::join(x.data(), x.data() + dim, ", "));
}

template <int dim>
std::string Equilibrium<dim>::describe_worst_point(std::span<const double> du) const {
  const auto& weights = parts_.weights;
  const MostStrained worst = most_strained(weights, parts_.nodes, du);
  const double largest = max_over_ranks(parts_.comm, worst.strain);
  std::string own;
  if (worst.entry >= 0 && worst.strain == largest) {
    const auto group = std::find_if(weights.groups.begin(), weights.groups.end(), [&](auto& g) {
      return worst.entry >= g.first && worst.entry < g.last;
    });
    GroupDisplacements<dim> of_group;
    parts_.nodes.gather(weights.nodes_of(*group), du, of_group.data());
    const std::int32_t p = weights.point[worst.entry];
    StressUpdate<dim> stress;
    const bool admissible = update(
        LawInStep<MaterialLaw<dim>, dim>{
            law_of<dim>(parts_.laws, p, parts_.bodies[group->body].material.law),
            context_.of_point(parts_.points, p)},
        displacement_gradient(weights, worst.entry, of_group.data()), parts_.points.history[p],
        stress, static_cast<Tangent<dim>*>(nullptr));
    own = fmt::format("{}: strain increment {:.3g}, {}", describe_point(p), worst.strain,
                      admissible ? fmt::format("volume ratio of the step {:.3g}, {}", stress.J,
                                               region_name(stress.region))
                                 : "inadmissible");
  }
  return first_text(parts_.comm, own);
}

template class Equilibrium<2>;
template class Equilibrium<3>;

}  // namespace gabion::mpm
