// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/wall_conditions.hpp"

#include <algorithm>
#include <map>

#include "common/mechanics/mesh/boundary.hpp"

namespace gabion::mpm {

namespace {

// Walls whose normals differ by less than this (sine of the angle) are one wall.
constexpr double same_direction = 1e-6;

// Remove the direction n from the range of the projector Q.
template <int dim>
void forbid(const Vector<dim>& n, Matrix<dim>& Q) {
  const Vector<dim> rest = Q * n;
  if (rest.norm() < same_direction) return;
  const Vector<dim> d = rest.normalized();
  Q -= d * d.transpose();
}

}  // namespace

template <int dim>
WallConditions<dim>::WallConditions(const Mesh<dim>& grid, const std::vector<WallSettings>& walls) {
  std::map<std::int32_t, Matrix<dim>> projectors;
  for (const WallSettings& wall : walls) {
    if (wall.fixed) {
      for (const auto i : grid.group_nodes(wall.group, wall.where)) {
        projectors[i] = Matrix<dim>::Zero();
      }
      continue;
    }
    const auto& facets = grid.facets(wall.group, wall.where);
    const int per_facet = num_nodes(facet_type(grid.cell_type));
    const auto geometry = facet_geometry<dim>(grid.nodes, facet_type(grid.cell_type), facets);
    for (std::size_t k = 0; k < facets.size(); ++k) {
      auto [entry, unused] = projectors.try_emplace(facets[k], Matrix<dim>::Identity());
      forbid<dim>(geometry[k / per_facet].normal, entry->second);
    }
  }
  for (const auto& [node, Q] : projectors) {
    grid_nodes_.push_back(node);
    grid_projectors_.push_back(Q);
  }
}

template <int dim>
bool WallConditions<dim>::holds(std::int32_t grid_node) const {
  return std::binary_search(grid_nodes_.begin(), grid_nodes_.end(), grid_node);
}

template <int dim>
void WallConditions<dim>::select(const GridNodes<dim>& nodes) {
  constrained_.clear();
  projectors_.clear();
  for (std::size_t k = 0; k < grid_nodes_.size(); ++k) {
    const std::int32_t i = nodes.active[grid_nodes_[k]];
    if (i < 0) continue;
    constrained_.push_back(i);
    projectors_.push_back(grid_projectors_[k]);
  }
}

template <int dim>
void WallConditions<dim>::project(std::span<double> x) const {
  for (std::size_t k = 0; k < constrained_.size(); ++k) {
    Eigen::Map<Vector<dim>> x_i(x.data() + static_cast<std::size_t>(constrained_[k]) * dim);
    x_i = (projectors_[k] * x_i).eval();
  }
}

template class WallConditions<2>;
template class WallConditions<3>;

}  // namespace gabion::mpm
