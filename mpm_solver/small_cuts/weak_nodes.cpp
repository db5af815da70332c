// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/small_cuts/weak_nodes.hpp"

#include <algorithm>

#include "mpm_solver/contact/goes_through.hpp"

namespace gabion::mpm {

namespace {

// A weak node has less than this part of its mean share in the mass of its points.
constexpr double weak_share = 0.75;

// Share of the longest edge: a node that is no farther behind a facet lies on it, and sights begin
// so far beside themselves (aside).
constexpr double tiny_share = 1e-6;

template <int dim>
double longest_edge(const BackgroundGrid<dim>& grid) {
  double longest = 0;
  Vector<dim> corners[max_cell_nodes];
  for (std::int32_t c = 0; c < grid.num_cells(); ++c) {
    grid.corners(c, corners);
    for (int i = 1; i < grid.nodes_per_cell(); ++i) {
      for (int j = 0; j < i; ++j) longest = std::max(longest, (corners[i] - corners[j]).norm());
    }
  }
  return longest;
}

}  // namespace

template <int dim>
bool may_have_weak_nodes(const SmallCutSettings& settings, const BackgroundGrid<dim>& grid,
                         const std::vector<Body<dim>>& bodies) {
  if (!grid.is_simplex() || settings.method == SmallCutMethod::none) return false;
  return std::any_of(bodies.begin(), bodies.end(),
                     [](const Body<dim>& body) { return !is_elastic(body.material.law); });
}

template <int dim>
FacetSights<dim>::FacetSights(const std::vector<StartSurface<dim>>& surfaces,
                              const BackgroundGrid<dim>& grid)
    : faces_(surfaces),
      num_surfaces_(surfaces.size()),
      reach_(longest_edge(grid)),
      tiny_(tiny_share * reach_),
      left_out_(surfaces.size(), 0) {}

template <int dim>
bool FacetSights<dim>::follow(const Surfaces<dim>& surfaces) {
  bool same = hash_.has_value();
  std::vector<char> acts(num_surfaces_, 0);
  for (std::size_t k = 0; k < num_surfaces_; ++k) {
    if (faces_.num_simplices[k] == 0) continue;
    const auto x = surfaces.accepted_vertices(k);
    acts[k] = x.empty() || left_out_[k] ? 0 : 1;
    if (faces_.move(k, x)) same = false;
  }
  if (same && acts == acts_) return !acting_.empty();
  acts_ = std::move(acts);
  acting_.clear();
  for (std::size_t s = 0; s < faces_.simplices.size(); ++s) {
    if (acts_[faces_.surface[s]] != 0) acting_.push_back(faces_.simplices[s]);
  }
  normals_.clear();
  for (const auto& simplex : acting_) {
    normals_.push_back(simplex_normal<dim>(corners_of<dim>(simplex, faces_.vertices)));
  }
  hash_.emplace(acting_, faces_.vertices, reach_);
  return !acting_.empty();
}

template <int dim>
bool FacetSights<dim>::is_behind(const Vector<dim>& x, const Vector<dim>& y) const {
  const Vector<dim> from = y + tiny_ * aside<dim>();
  const auto near = hash_->near(x);
  return std::any_of(near.begin(), near.end(), [&](std::int32_t s) {
    const auto corners = corners_of<dim>(acting_[s], faces_.vertices);
    return (x - corners[0]).dot(normals_[s]) < -tiny_ &&
           (from - corners[0]).dot(normals_[s]) > tiny_ && goes_through(from, x, corners);
  });
}

template <int dim>
std::vector<char> find_weak_nodes(const FacetSights<dim>& sights, const MaterialPoints<dim>& points,
                                  const PointWeights<dim>& weights, const GridNodes<dim>& nodes,
                                  std::span<const double> reach) {
  std::vector<double> moments(static_cast<std::size_t>(nodes.size()) * dim, 0.0);
  for (const CellGroup& group : weights.groups) {
    const auto grid_nodes = weights.nodes_of(group);
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const std::int32_t p = weights.point[e];
      const std::uint8_t* local = weights.local_of(e);
      for (int i = 0; i < weights.num_nodes(e); ++i) {
        double* sum = &moments[std::size_t{dim} * nodes.active[grid_nodes[local[i]]]];
        for (int d = 0; d < dim; ++d) sum[d] += weights.N_of(e)[i] * points.m[p] * points.x[p][d];
      }
    }
  }
  nodes.shared.sum(moments, dim);
  std::vector<char> weak(nodes.size(), 0);
  for (std::int32_t i = 0; i < nodes.size(); ++i) {
    if (!(nodes.m[i] > 0) || nodes.m[i] >= weak_share / (dim + 1) * reach[i]) continue;
    const Vector<dim> mean =
        Eigen::Map<const Vector<dim>>(&moments[std::size_t{dim} * i]) / nodes.m[i];
    weak[i] = sights.is_behind(nodes.x[i], mean) ? 1 : 0;
  }
  return weak;
}

template bool may_have_weak_nodes<2>(const SmallCutSettings&, const BackgroundGrid<2>&,
                                     const std::vector<Body<2>>&);
template bool may_have_weak_nodes<3>(const SmallCutSettings&, const BackgroundGrid<3>&,
                                     const std::vector<Body<3>>&);
template class FacetSights<2>;
template class FacetSights<3>;
template std::vector<char> find_weak_nodes<2>(const FacetSights<2>&, const MaterialPoints<2>&,
                                              const PointWeights<2>&, const GridNodes<2>&,
                                              std::span<const double>);
template std::vector<char> find_weak_nodes<3>(const FacetSights<3>&, const MaterialPoints<3>&,
                                              const PointWeights<3>&, const GridNodes<3>&,
                                              std::span<const double>);

}  // namespace gabion::mpm
