// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/walls/wall_conditions.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <set>

#include "common/mechanics/mesh/boundary.hpp"

namespace gabion::mpm {

namespace {

// Walls whose normals differ by less than this (sine of the angle) are one wall.
constexpr double same_direction = 1e-6;

// Motions of walls that share a node agree up to this share of the larger one.
constexpr double same_motion = 1e-9;

}  // namespace

template <int dim>
WallConditions<dim>::WallConditions(const BackgroundGrid<dim>& grid,
                                    const std::vector<WallSettings>& walls)
    : walls_(walls), steps_(walls.size(), Vector<dim>::Zero()) {
  const CellType type = facet_type(grid.cell_type);
  std::set<std::int32_t> held;
  for (const WallSettings& wall : walls_) {
    const auto nodes = find_group_nodes(grid.facet_groups, wall.group, wall.where);
    held.insert(nodes.begin(), nodes.end());
  }
  for (const std::int32_t i : held) {
    nodes_.emplace_back();
    nodes_.back().grid_node = i;
  }
  const auto num_walls = static_cast<std::int32_t>(walls_.size());
  for (std::int32_t w = 0; w < num_walls; ++w) {
    if (!walls_[w].fixed) continue;
    for (const std::int32_t i :
         find_group_nodes(grid.facet_groups, walls_[w].group, walls_[w].where)) {
      for (int d = 0; d < dim; ++d) add(index_of(i), {w, Vector<dim>::Unit(d)});
    }
  }
  for (std::int32_t w = 0; w < num_walls; ++w) {
    if (walls_[w].fixed) continue;
    const auto& facets = find_facets(grid.facet_groups, walls_[w].group, walls_[w].where);
    const auto geometry = facet_geometry(grid, facets);
    for (std::size_t k = 0; k < facets.size(); ++k) {
      add(index_of(facets[k]), {w, geometry[k / num_nodes(type)].normal});
    }
  }
  for (Node& node : nodes_) set_shares(node);
}

template <int dim>
std::size_t WallConditions<dim>::index_of(std::int32_t grid_node) const {
  const auto found =
      std::lower_bound(nodes_.begin(), nodes_.end(), grid_node,
                       [](const Node& a, std::int32_t b) { return a.grid_node < b; });
  return static_cast<std::size_t>(found - nodes_.begin());
}

template <int dim>
bool WallConditions<dim>::holds(std::int32_t grid_node) const {
  const std::size_t k = index_of(grid_node);
  return k < nodes_.size() && nodes_[k].grid_node == grid_node;
}

// Remove the direction of `hold` from the range of the node's projector.
template <int dim>
void WallConditions<dim>::add(std::size_t k, const Hold& hold) {
  Node& node = nodes_[k];
  const Vector<dim> rest = node.Q * hold.n;
  if (node.num_holds == dim || rest.norm() < same_direction) {
    repetitions_.push_back({k, hold});
    return;
  }
  const Vector<dim> d = rest.normalized();
  node.Q -= d * d.transpose();
  node.holds[node.num_holds++] = hold;
  if (node.num_holds == dim) node.Q.setZero();
}

template <int dim>
void WallConditions<dim>::set_shares(Node& node) {
  Eigen::Matrix<double, dim, Eigen::Dynamic, 0, dim, dim> N(dim, node.num_holds);
  for (int k = 0; k < node.num_holds; ++k) N.col(k) = node.holds[k].n;
  node.shares.topRows(node.num_holds) = (N.transpose() * N).inverse() * N.transpose();
}

template <int dim>
void WallConditions<dim>::begin_step(double time, double dt) {
  double largest = 0;
  bool any = false;
  for (std::size_t w = 0; w < walls_.size(); ++w) {
    const WallMotion& motion = walls_[w].motion;
    if (!motion.moves()) continue;
    any = true;
    steps_[w] = motion.displacement<dim>(time + dt) - motion.displacement<dim>(time);
    largest = std::max(largest, steps_[w].norm());
  }
  move_ = largest > 0;
  if (!any) return;
  for (Node& node : nodes_) {
    node.w.setZero();  // w . n_k = step . n_k, w in the range of the n_k
    for (int k = 0; k < node.num_holds; ++k) {
      const Hold& hold = node.holds[k];
      node.w += hold.n.dot(steps_[hold.wall]) * node.shares.row(k).transpose();
    }
  }
  for (const Repetition& repetition : repetitions_) {
    require_agreement(repetition, same_motion * largest);
  }
}

template <int dim>
void WallConditions<dim>::require_agreement(const Repetition& repetition, double tolerance) const {
  const Node& node = nodes_[repetition.node];
  const Hold& hold = repetition.hold;
  if (std::abs(hold.n.dot(node.w - steps_[hold.wall])) <= tolerance) return;
  throw ConfigError(
      fmt::format("{}: found a motion of \"{}\" that \"{}\", which holds grid node {} in the same "
                  "direction, does not take part in, allowed: equal motions where walls meet",
                  walls_[hold.wall].where, walls_[hold.wall].group,
                  walls_[node.holds[0].wall].group, node.grid_node));
}

template <int dim>
void WallConditions<dim>::select(const GridNodes<dim>& nodes) {
  selected_.clear();
  constrained_.clear();
  projectors_.clear();
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    const std::int32_t i = nodes.active[nodes_[k].grid_node];
    if (i < 0) continue;
    selected_.push_back(k);
    constrained_.push_back(i);
    projectors_.push_back(nodes_[k].Q);
  }
}

template <int dim>
void WallConditions<dim>::project(std::span<double> x) const {
  for (std::size_t k = 0; k < constrained_.size(); ++k) {
    Eigen::Map<Vector<dim>> x_i(x.data() + static_cast<std::size_t>(constrained_[k]) * dim);
    x_i = (projectors_[k] * x_i).eval();
  }
}

template <int dim>
void WallConditions<dim>::impose(std::span<double> x, double scale) const {
  project(x);
  for (std::size_t k = 0; k < constrained_.size(); ++k) {
    Eigen::Map<Vector<dim>> x_i(x.data() + static_cast<std::size_t>(constrained_[k]) * dim);
    x_i += scale * nodes_[selected_[k]].w;
  }
}

template <int dim>
std::vector<Vector<dim>> WallConditions<dim>::forces(std::span<const double> r,
                                                     const SharedNodes& shared) const {
  std::vector<Vector<dim>> sums(walls_.size(), Vector<dim>::Zero());
  for (std::size_t k = 0; k < constrained_.size(); ++k) {
    if (!shared.owns(constrained_[k])) continue;
    const Node& node = nodes_[selected_[k]];
    const Eigen::Map<const Vector<dim>> r_i(r.data() +
                                            static_cast<std::size_t>(constrained_[k]) * dim);
    for (int m = 0; m < node.num_holds; ++m) {
      sums[node.holds[m].wall] += node.shares.row(m).dot(r_i) * node.holds[m].n;
    }
  }
  return sums;
}

template class WallConditions<2>;
template class WallConditions<3>;

}  // namespace gabion::mpm
