// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/equilibrium.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "common/mechanics/norm.hpp"
#include "common/mechanics/ranks/sum.hpp"

namespace gabion::mpm {

namespace {

// Where soil flies freely no force is left to compare the residual with. The force that would stop
// a node within the step counts by this share.
constexpr double share_of_stopping = 1e-3;

}  // namespace

template <int dim>
Equilibrium<dim>::Equilibrium(const Parts& parts)
    : parts_(parts),
      internal_({parts.grid, parts.bodies, parts.points, parts.weights, parts.nodes, parts.trial},
                parts.cell_size, parts.same_strain),
      inertia_m_(parts.nodes.m) {
  const auto& nodes = parts_.nodes;
  double total = 0;
  for (const double mass : nodes.m) total += mass;
  // Without a floor the matrix is singular where soil without stiffness hangs on a light node.
  const double floor = parts_.mass_floor * total / std::max(1, nodes.size());
  for (double& mass : inertia_m_) mass = std::max(mass, floor);
  v_.assign(nodes.v.empty() ? nullptr : nodes.v.front().data(),
            nodes.v.empty() ? nullptr : nodes.v.front().data() + nodes.v.size() * dim);
  a_.assign(nodes.a.empty() ? nullptr : nodes.a.front().data(),
            nodes.a.empty() ? nullptr : nodes.a.front().data() + nodes.a.size() * dim);
  parts_.walls.project(v_);
  parts_.walls.project(a_);
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
  if (rank_of(parts_.comm) == 0) {
    for (const auto& boundary : parts_.boundaries) boundary.append_cells(offsets, cell_nodes);
  }
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
    if (worst >= 0) {
      result.reason = fmt::format("material point {} would be squeezed below {} of its volume",
                                  parts_.points.id[worst], min_J_ratio);
    }
    return result;
  }
  const bool root = rank_of(parts_.comm) == 0;
  f_sum_ = internal_.forces();
  sum_over_ranks(parts_.comm, std::span<double>(f_sum_));
  std::fill(r.begin(), r.end(), 0.0);
  if (root) {
    for (auto& boundary : parts_.boundaries) boundary.add_forces(du, r, K);
  }
  if (parts_.ghost != nullptr) parts_.ghost->add_forces(du, r, K);
  if (!parts_.boundaries.empty() || parts_.ghost != nullptr) sum_over_ranks(parts_.comm, r);

  const double external = add_body_forces(du, r, root ? K : nullptr);
  parts_.walls.project(r);
  if (K) K->constrain(parts_.walls.constrained(), parts_.walls.projectors(), root);
  result.force_scale = std::max(norm_of(f_sum_), external);
  result.admissible = std::isfinite(result.force_scale) && std::isfinite(norm_of(r));
  if (!result.admissible) result.reason = "forces are not finite";
  return result;
}

// Add f_ext - f_int - f_inertia to r and the inertia to K.
template <int dim>
double Equilibrium<dim>::add_body_forces(std::span<const double> du, std::span<double> r,
                                         BlockMatrix<dim>* K) const {
  const double dt = parts_.dt;
  const NewmarkBossak& scheme = parts_.scheme;
  const double slope = scheme.inertia_slope(dt);
  double external = 0, inertial = 0, stopping = 0;
  for (std::int32_t i = 0; i < parts_.nodes.size(); ++i) {
    const double mass = inertia_m_[i];
    for (int d = 0; d < dim; ++d) {
      const std::size_t k = static_cast<std::size_t>(i) * dim + d;
      const double a_new = scheme.acceleration(du[k], v_[k], a_[k], dt);
      const double f_inertia = mass * scheme.inertia(a_new, a_[k]);
      const double f_ext = mass * parts_.gravity[d];
      r[k] += f_ext - f_inertia - f_sum_[k];
      external += f_ext * f_ext;
      inertial += f_inertia * f_inertia;
      const double f_stop = share_of_stopping * mass * v_[k] / dt;
      stopping += f_stop * f_stop;
    }
    if (K) K->add_diagonal(i, mass * slope);
  }
  return std::sqrt(std::max({external, inertial, stopping}));
}

template <int dim>
std::string Equilibrium<dim>::describe_node(std::size_t i) const {
  const std::int32_t node = parts_.nodes.grid_node[i];
  const Vector<dim>& x = parts_.grid.mesh.nodes[node];
  return fmt::format("grid node {} at ({:.4g})", node, fmt::join(x.data(), x.data() + dim, ", "));
}

template class Equilibrium<2>;
template class Equilibrium<3>;

}  // namespace gabion::mpm
