// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/walls/inelastic_projection.hpp"

#include <algorithm>
#include <utility>

#include "mpm_solver/grid/transfer.hpp"
#include "mpm_solver/points/flat.hpp"

namespace gabion::mpm {

namespace {

// x <- (1 - Q) x.
template <int dim>
void hold(const WallConditions<dim>& walls, std::vector<double>& x) {
  std::vector<double> held(x.size(), 0.0);
  for (std::size_t k = 0; k < walls.constrained().size(); ++k) {
    const std::ptrdiff_t first = std::ptrdiff_t{walls.constrained()[k]} * dim;
    const Eigen::Map<const Vector<dim>> x_i(x.data() + first);
    Eigen::Map<Vector<dim>>(held.data() + first) = x_i - walls.projectors()[k] * x_i;
  }
  x = std::move(held);
}

}  // namespace

template <int dim>
void InelasticProjection<dim>::forget() {
  acts_ = false;
  at_walls_.clear();
  values_.clear();
  J_.clear();
  totals_ = {};
}

template <int dim>
void InelasticProjection<dim>::list_points(const MaterialPoints<dim>& points,
                                           const PointWeights<dim>& weights,
                                           const WallConditions<dim>& walls,
                                           const GridNodes<dim>& nodes) {
  std::vector<char> is_held(nodes.m.size(), 0);
  for (const std::int32_t i : walls.constrained()) is_held[i] = nodes.m[i] > weightless_;
  std::int32_t active[max_group_nodes<dim>];
  for (std::int32_t g = 0; g < std::ssize(weights.groups); ++g) {
    const CellGroup& group = weights.groups[g];
    nodes.list_active(weights.nodes_of(group), active);
    if (std::none_of(active, active + group.num_nodes, [&](auto i) { return is_held[i] != 0; })) {
      continue;
    }
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const double m = points.m[weights.point[e]];
      const std::size_t before = values_.size();
      for (int k = 0; k < weights.num_nodes(e); ++k) {
        const std::int32_t i = active[weights.local_of(e)[k]];
        if (is_held[i]) values_.push_back({i, weights.N_of(e)[k] * m / nodes.m[i]});
      }
      if (values_.size() == before) continue;
      at_walls_.push_back({g, e, static_cast<std::int32_t>(values_.size()), m, Vector<dim>::Zero()});
    }
  }
}

// dv = W impulse at the held nodes; each point keeps its own.
template <int dim>
void InelasticProjection<dim>::respond(const SharedNodes& shared, std::span<const double> impulse,
                                       std::span<double> dv) {
  std::fill(dv.begin(), dv.end(), 0.0);
  const Value* first = values_.data();
  for (WallPoint& point : at_walls_) {
    const Value* const last = values_.data() + point.last_value;
    point.dv.setZero();
    for (const Value* value = first; value < last; ++value) {
      const double* const J = impulse.data() + std::ptrdiff_t{value->node} * dim;
      point.dv += value->rho / point.m * Eigen::Map<const Vector<dim>>(J);
    }
    for (const Value* value = first; value < last; ++value) {
      Eigen::Map<Vector<dim>>(dv.data() + std::ptrdiff_t{value->node} * dim) +=
          value->rho * point.dv;
    }
    first = last;
  }
  shared.sum(dv, dim);
}

// J from the velocity r that is missing at the walls.
template <int dim>
void InelasticProjection<dim>::search(const WallConditions<dim>& walls, const GridNodes<dim>& nodes,
                                      std::vector<double> r) {
  constexpr double middle = (1 + least) / 2, radius = (1 - least) / 2, sigma = middle / radius;
  const std::size_t n = r.size();
  J_.assign(n, 0.0);
  std::vector<double> d(n), dv(n);
  for (std::size_t k = 0; k < n; ++k) d[k] = nodes.m[k / dim] * r[k] / middle;
  double rho = 1 / sigma;
  for (int sweep = 1;; ++sweep) {
    for (std::size_t k = 0; k < n; ++k) J_[k] += d[k];
    if (sweep == num_sweeps) return;
    respond(nodes.shared, d, dv);
    const double next = 1 / (2 * sigma - rho);
    for (std::size_t k = 0; k < walls.constrained().size(); ++k) {
      const std::int32_t i = walls.constrained()[k];
      const Eigen::Map<const Vector<dim>> dv_i(&dv[std::size_t(i) * dim]);
      Eigen::Map<Vector<dim>> r_i(&r[std::size_t(i) * dim]), d_i(&d[std::size_t(i) * dim]);
      r_i -= dv_i - walls.projectors()[k] * dv_i;
      d_i = next * (rho * d_i + 2 / radius * nodes.m[i] * r_i);
    }
    rho = next;
  }
}

// Set the velocity mapped from the points after the projection.
template <int dim>
void InelasticProjection<dim>::move_nodes(const PointWeights<dim>& weights,
                                          GridNodes<dim>& nodes) const {
  std::vector<double> dp(nodes.v.size() * dim, 0.0);  // change of momentum
  std::int32_t active[max_group_nodes<dim>];
  for (const WallPoint& point : at_walls_) {
    nodes.list_active(weights.nodes_of(weights.groups[point.group]), active);
    for (int k = 0; k < weights.num_nodes(point.entry); ++k) {
      const std::ptrdiff_t node = active[weights.local_of(point.entry)[k]];
      Eigen::Map<Vector<dim>>(dp.data() + node * dim) +=
          weights.N_of(point.entry)[k] * point.m * point.dv;
    }
  }
  nodes.shared.sum(dp, dim);
  const auto v = flat(nodes.v);
  for (std::size_t k = 0; k < v.size(); ++k) {
    if (nodes.m[k / dim] > weightless_) v[k] += dp[k] / nodes.m[k / dim];
  }
}

// Velocity that the points would have at the held nodes if they moved with the nodes and walls.
template <int dim>
std::vector<double> InelasticProjection<dim>::smooth(const PointWeights<dim>& weights,
                                                     const GridNodes<dim>& nodes,
                                                     std::span<const double> v) const {
  std::vector<double> mapped(v.size(), 0.0);
  std::int32_t active[max_group_nodes<dim>];
  const Value* first = values_.data();
  for (const WallPoint& point : at_walls_) {
    nodes.list_active(weights.nodes_of(weights.groups[point.group]), active);
    Vector<dim> of_point = Vector<dim>::Zero();
    for (int k = 0; k < weights.num_nodes(point.entry); ++k) {
      const std::ptrdiff_t node = active[weights.local_of(point.entry)[k]];
      of_point += weights.N_of(point.entry)[k] * Eigen::Map<const Vector<dim>>(&v[node * dim]);
    }
    const Value* const last = values_.data() + point.last_value;
    for (const Value* value = first; value < last; ++value) {
      Eigen::Map<Vector<dim>>(&mapped[std::ptrdiff_t{value->node} * dim]) += value->rho * of_point;
    }
    first = last;
  }
  nodes.shared.sum(mapped, dim);
  return mapped;
}

// Limit r so that no held node gets more than it has: |u + r| <= |u|.
template <int dim>
void InelasticProjection<dim>::limit(const WallConditions<dim>& walls, std::span<const double> u,
                                     std::vector<double>& r) const {
  for (const std::int32_t i : walls.constrained()) {
    const Eigen::Map<const Vector<dim>> had(u.data() + std::ptrdiff_t{i} * dim);
    Eigen::Map<Vector<dim>> missing(r.data() + std::ptrdiff_t{i} * dim);
    const Vector<dim> wanted = had + missing;
    const double most = had.norm(), size = wanted.norm();
    if (size > most) missing = most / size * wanted - had;
  }
}

// The points get the energy J . (u + W J / 2) in the frame of the walls; where that is a gain, J is
// reduced to the largest share without one.
// @returns the energy, <= 0 [J]
template <int dim>
double InelasticProjection<dim>::avoid_gain(const SharedNodes& shared, std::span<const double> u,
                                            std::vector<double>& W_J) {
  double sums[2] = {};
  auto& [J_u, J_W_J] = sums;
  for (std::size_t k = 0; k < u.size(); ++k) {
    if (!shared.owns(static_cast<std::int32_t>(k / dim))) continue;
    J_u += J_[k] * u[k];
    J_W_J += J_[k] * W_J[k];
  }
  shared.total(sums);
  const double gain = J_u + 0.5 * J_W_J;
  if (gain <= 0) return gain;
  const double share = std::max(0.0, -2 * J_u / J_W_J);
  for (double& J : J_) J *= share;
  respond(shared, J_, W_J);
  return 0;
}

template <int dim>
void InelasticProjection<dim>::find(const MaterialPoints<dim>& points,
                                    const PointWeights<dim>& weights,
                                    const WallConditions<dim>& walls, double dt,
                                    GridNodes<dim>& nodes) {
  forget();
  weightless_ = weightless_mass(nodes);
  list_points(points, weights, walls, nodes);
  const SharedNodes& shared = nodes.shared;
  acts_ = !shared.all(at_walls_.empty());
  if (!acts_) return;
  const auto v = flat(nodes.v);
  std::vector<double> of_walls(v.size(), 0.0), r(v.size()), W_J(v.size());
  walls.impose(of_walls, 1 / dt);
  std::vector<double> with_walls(v.begin(), v.end());
  walls.impose(with_walls, 1 / dt);
  const std::vector<double> wanted = smooth(weights, nodes, with_walls);
  for (std::size_t k = 0; k < v.size(); ++k) {
    if (nodes.m[k / dim] > weightless_) r[k] = wanted[k] - v[k];
  }
  hold(walls, r);
  std::vector<double> u(v.begin(), v.end());
  hold(walls, u);
  for (std::size_t k = 0; k < u.size(); ++k) u[k] -= of_walls[k];
  limit(walls, u, r);
  search(walls, nodes, std::move(r));
  respond(shared, J_, W_J);
  const double gain = avoid_gain(shared, u, W_J);
  const std::vector<double> before(v.begin(), v.end());
  move_nodes(weights, nodes);
  walls.impose(v, 1 / dt);
  double sums[1 + 2 * dim] = {};
  for (std::size_t k = 0; k < v.size(); ++k) {
    if (!shared.owns(static_cast<std::int32_t>(k / dim))) continue;
    sums[0] += J_[k] * of_walls[k];
    sums[1 + k % dim] += J_[k];
    sums[1 + dim + k % dim] += nodes.m[k / dim] * (v[k] - before[k]) - J_[k];
  }
  shared.total(sums);
  totals_ = {.loss = -gain - sums[0],
             .work = sums[0],
             .impulse = Eigen::Map<const Vector<dim>>(sums + 1),
             .of_nodes = Eigen::Map<const Vector<dim>>(sums + 1 + dim)};
}

template <int dim>
void InelasticProjection<dim>::kick(const PointWeights<dim>& weights,
                                    MaterialPoints<dim>& points) const {
  for (const WallPoint& point : at_walls_) points.v[weights.point[point.entry]] += point.dv;
}

template class InelasticProjection<2>;
template class InelasticProjection<3>;

}  // namespace gabion::mpm
