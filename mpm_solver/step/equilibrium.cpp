// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step/equilibrium.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "common/base/require.hpp"
#include "common/mechanics/norm.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "common/mechanics/ranks/text.hpp"
#include "mpm_solver/stress/point_motion.hpp"

namespace gabion::mpm {

namespace {

// A node that points hardly weigh on gets this share of the mean nodal mass: without it the matrix
// is singular there once the soil around it has no stiffness. Small enough to be far below the
// error of the scheme, large enough for double precision.
constexpr double mass_floor = 1e-8;

// Of the mean stiffness of a node.
constexpr double support_share = 1e-4;

// Where soil flies freely no force is left to compare the residual with. The force that would stop
// a node within the step counts by this share.
constexpr double share_of_stopping = 1e-3;

}  // namespace

template <int dim>
Equilibrium<dim>::Equilibrium(const Parts& parts)
    : parts_(parts),
      internal_({.bodies = parts.bodies,
                 .points = parts.points,
                 .weights = parts.weights,
                 .nodes = parts.nodes,
                 .trial = parts.trial},
                parts.cell_size, parts.same_strain,
                parts.average_volumes ? std::optional(parts.comm) : std::nullopt),
      m_(parts.nodes.m) {
  const auto& nodes = parts_.nodes;
  if (parts_.with_inertia) {
    double total = 0;
    for (const double mass : nodes.m) total += mass;
    const double floor = mass_floor * total / std::max(1, nodes.size());
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
  sum_over_ranks(parts_.comm, std::span<double>(f_start_));
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
                   [](const auto& contact) { return contact->is_step_force(); })) {
    return {};
  }
  std::vector<double> change(r_before_walls_.size(), 0.0);
  for (const auto& contact : contacts) contact->add_step_force_change(change);
  sum_over_ranks(parts_.comm, std::span<double>(change));
  return change;
}

template <int dim>
std::vector<Vector<dim>> Equilibrium<dim>::wall_forces() const {
  const std::vector<double> change = step_force_change();
  if (change.empty()) return parts_.walls.forces(r_before_walls_);
  std::vector<double> r = r_before_walls_;
  const double extra = parts_.with_inertia ? parts_.scheme.step_force_weight() - 1 : 0;
  for (std::size_t k = 0; k < r.size(); ++k) r[k] -= extra * change[k];
  return parts_.walls.forces(r);
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
  for (const auto& contact : parts_.contacts) contact->append_cells(offsets, cell_nodes);
  if (parts_.ghost != nullptr) parts_.ghost->append_cells(offsets, cell_nodes);
}

template <int dim>
Evaluation Equilibrium<dim>::evaluate(std::span<const double> du, std::span<double> r,
                                      BlockMatrix<dim>* K) {
  Evaluation result;
  std::int32_t worst = -1;
  const bool admissible = internal_.evaluate(du, K, worst);
  if (max_over_ranks(parts_.comm, admissible ? 0 : 1) > 0) {
    result.admissible = false;
    const std::string own = worst < 0 ? ""
                                      : fmt::format("{} would be squeezed below {} of its volume",
                                                    describe_point(worst), min_J_ratio);
    result.reason = first_text(parts_.comm, own);
    return result;
  }
  if (K && brace_ > 0) internal_.add_brace(brace_, *K);
  const bool root = rank_of(parts_.comm) == 0;
  f_sum_ = internal_.forces();
  sum_over_ranks(parts_.comm, std::span<double>(f_sum_));
  std::fill(r.begin(), r.end(), 0.0);
  for (const auto& contact : parts_.contacts) contact->add_forces(du, r, K);
  if (parts_.ghost != nullptr) parts_.ghost->add_forces(du, r, K);
  if (K && supported_) {
    const double support = support_share * K->mean_diagonal();
    for (std::int32_t i = 0; i < K->num_nodes(); ++i) K->add_diagonal(i, support);
  }
  if (!parts_.contacts.empty() || parts_.ghost != nullptr) sum_over_ranks(parts_.comm, r);

  double external = add_weight(r);
  if (parts_.with_inertia) external = std::max(external, add_inertia(du, r, root ? K : nullptr));
  for (std::size_t k = 0; k < r.size(); ++k) r[k] -= f_sum_[k];
  for (std::size_t k = 0; k < f_start_.size(); ++k) r[k] += f_start_[k];
  r_before_walls_.assign(r.begin(), r.end());
  if (K && !wall_step_.empty()) subtract_wall_step(*K, r);
  parts_.walls.project(r);
  if (K) K->constrain(parts_.walls.constrained(), parts_.walls.projectors(), root);
  result.likely_last = first_evaluation_ && (parts_.nearly_linear || internal_.neighbours_matrix());
  first_evaluation_ = false;
  result.force_scale = std::max(norm_of(f_sum_), external);
  result.admissible = std::isfinite(result.force_scale) && std::isfinite(norm_of(r));
  if (!result.admissible) result.reason = "forces are not finite";
  return result;
}

template <int dim>
bool Equilibrium<dim>::brace(double share) {
  brace_ = share;
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
  sum_over_ranks(parts_.comm, std::span<double>(f));
  for (std::size_t k = 0; k < r.size(); ++k) r[k] -= f[k];
}

// Add f_ext to r. @returns |f_ext|
template <int dim>
double Equilibrium<dim>::add_weight(std::span<double> r) const {
  double external = 0;
  for (std::int32_t i = 0; i < parts_.nodes.size(); ++i) {
    for (int d = 0; d < dim; ++d) {
      const std::size_t k = static_cast<std::size_t>(i) * dim + d;
      const double f_ext =
          m_[i] * parts_.gravity[d] + (parts_.f_body.empty() ? 0 : parts_.f_body[k]);
      r[k] += f_ext;
      external += f_ext * f_ext;
    }
  }
  return std::sqrt(external);
}

// Add -f_inertia to r and its slope to K.
// @returns the larger one of |f_inertia| and what counts of the stopping force
template <int dim>
double Equilibrium<dim>::add_inertia(std::span<const double> du, std::span<double> r,
                                     BlockMatrix<dim>* K) const {
  const double dt = parts_.dt;
  const NewmarkBossak& scheme = parts_.scheme;
  const double slope = scheme.inertia_slope(dt);
  double inertial = 0, stopping = 0;
  for (std::int32_t i = 0; i < parts_.nodes.size(); ++i) {
    const double mass = m_[i];
    for (int d = 0; d < dim; ++d) {
      const std::size_t k = static_cast<std::size_t>(i) * dim + d;
      const double a_new = scheme.acceleration(du[k], v_[k], a_[k], dt);
      const double f_inertia = mass * scheme.inertia(a_new, a_[k]);
      r[k] -= f_inertia;
      inertial += f_inertia * f_inertia;
      const double f_stop = share_of_stopping * mass * v_[k] / dt;
      stopping += f_stop * f_stop;
    }
    if (K) K->add_diagonal(i, mass * slope);
  }
  return std::sqrt(std::max(inertial, stopping));
}

template <int dim>
std::string Equilibrium<dim>::describe_node(std::size_t i) const {
  const std::int32_t node = parts_.nodes.grid_node[i];
  const Vector<dim>& x = parts_.grid.mesh.nodes[node];
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
    const bool admissible =
        update(parts_.bodies[group->body].material.law,
               displacement_gradient(weights, worst.entry, of_group.data()),
               parts_.points.history[p], stress, static_cast<Tangent<dim>*>(nullptr));
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
