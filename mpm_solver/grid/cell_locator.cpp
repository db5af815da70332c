// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/grid/cell_locator.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <tuple>

#include "common/base/require.hpp"
#include "common/mechanics/elements/cell_facets.hpp"
#include "common/mechanics/elements/shape_functions.hpp"
#include "common/mechanics/mesh/boundary.hpp"

namespace gabion::mpm {

namespace {

constexpr double relative_tolerance = 1e-12;
constexpr double tie_factor = 1000;  // of the tolerance: a neighbour may contain the point as well
constexpr int max_walk = 100;        // cells; farther away the bins are cheaper

// Facet numbers (see `facet_nodes`) opposite to vertex i of a simplex.
constexpr int opposite_facet[2][4] = {{1, 2, 0, -1}, {3, 2, 1, 0}};

/// x(xi) and dx/dxi.
template <int dim>
Vector<dim> map_point(const Mesh<dim>& mesh, std::int32_t c, const Vector<dim>& xi,
                      Matrix<dim>& jacobian) {
  ShapeValues<dim> shape;
  shape_functions<dim>(mesh.cell_type, xi, shape);
  Vector<dim> x = Vector<dim>::Zero();
  jacobian.setZero();
  const auto cell = mesh.cell(c);
  for (std::size_t a = 0; a < cell.size(); ++a) {
    x += shape.N[a] * mesh.nodes[cell[a]];
    jacobian += mesh.nodes[cell[a]] * shape.dN[a].transpose();
  }
  return x;
}

/// Bounds of one cell's nodes.
template <int dim>
std::pair<Vector<dim>, Vector<dim>> bounds(const Mesh<dim>& mesh, std::int32_t c) {
  const auto cell = mesh.cell(c);
  Vector<dim> low = mesh.nodes[cell[0]], high = low;
  for (std::int32_t node : cell) {
    low = low.cwiseMin(mesh.nodes[node]);
    high = high.cwiseMax(mesh.nodes[node]);
  }
  return {low, high};
}

}  // namespace

template <int dim>
CellLocator<dim>::CellLocator(const Mesh<dim>& mesh)
    : mesh_(mesh),
      simplex_(mesh.nodes_per_cell() == dim + 1),
      facets_per_cell_(num_facets(mesh.cell_type)),
      neighbours_(cell_neighbours(mesh)) {
  require<ConfigError>(mesh.num_cells() > 0, "cell locator: the mesh has no cells");
  make_maps();
  make_bins();
}

template <int dim>
void CellLocator<dim>::make_maps() {
  double largest_coordinate = 0;
  for (const auto& x : mesh_.nodes) {
    largest_coordinate = std::max(largest_coordinate, x.cwiseAbs().maxCoeff());
  }
  maps_.resize(mesh_.num_cells());
  affine_.assign(mesh_.num_cells(), 1);
  for (std::int32_t c = 0; c < mesh_.num_cells(); ++c) {
    Map& map = maps_[c];
    Matrix<dim> jacobian, at_corner;
    map.origin = map_point<dim>(mesh_, c, Vector<dim>::Zero(), jacobian);
    require<ConfigError>(jacobian.determinant() > 0 && cell_volume(mesh_, c) > 0,
                         "cell locator: found no positive volume in cell {}", c);
    map.inverse = jacobian.inverse();
    // The rows of the inverse are gradients of xi: one over the height.
    const double largest_gradient = map.inverse.rowwise().norm().maxCoeff() * std::sqrt(dim);
    map.tolerance = relative_tolerance + 16 * std::numeric_limits<double>::epsilon() *
                                             largest_coordinate * largest_gradient;
    if (simplex_) continue;
    for (int corner = 0; corner < 1 << dim; ++corner) {
      Vector<dim> xi;
      for (int i = 0; i < dim; ++i) xi[i] = (corner >> i & 1) ? 1.0 : -1.0;
      map_point<dim>(mesh_, c, xi, at_corner);
      if ((map.inverse * (at_corner - jacobian)).norm() > 0.1 * map.tolerance) affine_[c] = 0;
    }
  }
}

template <int dim>
void CellLocator<dim>::make_bins() {
  std::tie(low_, high_) = bounds<dim>(mesh_, 0);
  Vector<dim> mean_extent = Vector<dim>::Zero();
  std::vector<std::pair<Vector<dim>, Vector<dim>>> boxes(mesh_.num_cells());
  for (std::int32_t c = 0; c < mesh_.num_cells(); ++c) {
    boxes[c] = bounds<dim>(mesh_, c);
    auto& [low, high] = boxes[c];
    mean_extent += (high - low) / mesh_.num_cells();
    const Vector<dim> margin =
        Vector<dim>::Constant(4 * maps_[c].tolerance * (high - low).maxCoeff());
    low -= margin;
    high += margin;
    low_ = low_.cwiseMin(low);
    high_ = high_.cwiseMax(high);
  }
  // A bin is as wide as the mean cell, but there are not many more bins than cells.
  const Vector<dim> ideal = (high_ - low_).cwiseQuotient(mean_extent);
  const double shrink = std::min(1.0, cube_side<dim>(4.0 * mesh_.num_cells() / ideal.prod()));
  for (int i = 0; i < dim; ++i) {
    num_bins_[i] = std::max(1, static_cast<int>(shrink * ideal[i]));
    bins_per_length_[i] = num_bins_[i] / (high_[i] - low_[i]);
  }
  fill_bins(boxes);
}

/// Count the cells of each bin, then list them.
template <int dim>
void CellLocator<dim>::fill_bins(const std::vector<std::pair<Vector<dim>, Vector<dim>>>& boxes) {
  const auto for_each_bin = [&](std::int32_t c, auto&& visit) {
    const auto first = bin_of(boxes[c].first), last = bin_of(boxes[c].second);
    Eigen::Matrix<int, 3, 1> from = Eigen::Matrix<int, 3, 1>::Zero(), to = from;
    from.template head<dim>() = first;
    to.template head<dim>() = last;
    for (int k = from[2]; k <= to[2]; ++k) {
      for (int j = from[1]; j <= to[1]; ++j) {
        for (int i = from[0]; i <= to[0]; ++i) visit((k * num_bins_[1] + j) * num_bins_[0] + i);
      }
    }
  };
  bin_starts_.assign(num_bins_.prod() + 1, 0);
  for (std::int32_t c = 0; c < mesh_.num_cells(); ++c) {
    for_each_bin(c, [&](int b) { ++bin_starts_[b + 1]; });
  }
  for (std::size_t b = 1; b < bin_starts_.size(); ++b) bin_starts_[b] += bin_starts_[b - 1];
  bin_cells_.resize(bin_starts_.back());
  std::vector<std::int32_t> next(bin_starts_.begin(), bin_starts_.end() - 1);
  for (std::int32_t c = 0; c < mesh_.num_cells(); ++c) {
    for_each_bin(c, [&](int b) { bin_cells_[next[b]++] = c; });
  }
}

template <int dim>
Eigen::Matrix<int, dim, 1> CellLocator<dim>::bin_of(const Vector<dim>& x) const {
  Eigen::Matrix<int, dim, 1> result;
  for (int i = 0; i < dim; ++i) {  // x is inside the bounds; the upper bound falls in the last bin
    result[i] =
        std::min(static_cast<int>((x[i] - low_[i]) * bins_per_length_[i]), num_bins_[i] - 1);
  }
  return result;
}

template <int dim>
inline Vector<dim> CellLocator<dim>::affine_coordinates(std::int32_t cell,
                                                        const Vector<dim>& x) const {
  const Map& map = maps_[cell];
  return map.inverse * (x - map.origin);
}

/// Newton's method with halved steps while the distance in x does not decrease.
template <int dim>
bool CellLocator<dim>::newton_coordinates(std::int32_t cell, const Vector<dim>& x,
                                          Vector<dim>& xi) const {
  xi = affine_coordinates(cell, x).cwiseMax(-1.0).cwiseMin(1.0);
  Matrix<dim> jacobian;
  Vector<dim> r = x - map_point<dim>(mesh_, cell, xi, jacobian);
  for (int iteration = 0; iteration < 50; ++iteration) {
    if (!(jacobian.determinant() > 0)) return false;
    const Vector<dim> step = jacobian.inverse() * r;
    if (step.cwiseAbs().maxCoeff() <= 0.1 * maps_[cell].tolerance) {
      xi += step;
      return true;
    }
    double share = 1.0;
    for (; share > 1e-4; share *= 0.5) {
      Matrix<dim> jacobian_trial;
      const Vector<dim> xi_trial = xi + share * step;
      const Vector<dim> r_trial = x - map_point<dim>(mesh_, cell, xi_trial, jacobian_trial);
      if (r_trial.squaredNorm() < r.squaredNorm() && jacobian_trial.determinant() > 0) {
        xi = xi_trial;
        r = r_trial;
        jacobian = jacobian_trial;
        break;
      }
    }
    if (share <= 1e-4) return step.cwiseAbs().maxCoeff() <= maps_[cell].tolerance;
  }
  return false;
}

template <int dim>
Vector<dim> CellLocator<dim>::local_coordinates(std::int32_t cell, const Vector<dim>& x) const {
  assert(0 <= cell && cell < mesh_.num_cells());
  if (affine_[cell]) return affine_coordinates(cell, x);
  Vector<dim> xi;
  require(newton_coordinates(cell, x, xi),
          "cell {} has no reference coordinates for a point at distance {} from its "
          "centre",
          cell, (x - maps_[cell].origin).norm());
  return xi;
}

template <int dim>
std::span<const std::int32_t> CellLocator<dim>::neighbours(std::int32_t cell) const {
  return {&neighbours_[static_cast<std::size_t>(cell) * facets_per_cell_],
          static_cast<std::size_t>(facets_per_cell_)};
}

template <int dim>
inline typename CellLocator<dim>::Nearest CellLocator<dim>::nearest_facet(
    const Vector<dim>& xi) const {
  Nearest nearest{0, std::numeric_limits<double>::infinity()};
  const auto visit = [&nearest](int facet, double distance) {
    if (distance < nearest.distance) nearest = {facet, distance};
  };
  if (simplex_) {
    visit(opposite_facet[dim - 2][0], 1.0 - xi.sum());
    for (int i = 0; i < dim; ++i) visit(opposite_facet[dim - 2][i + 1], xi[i]);
  } else {
    for (int i = 0; i < dim; ++i) {
      visit(brick_facet(dim, i, 0), 0.5 * (1.0 + xi[i]));
      visit(brick_facet(dim, i, 1), 0.5 * (1.0 - xi[i]));
    }
  }
  return nearest;
}

template <int dim>
inline typename CellLocator<dim>::Nearest CellLocator<dim>::nearest_facet(
    std::int32_t cell, const Vector<dim>& x) const {
  if (affine_[cell]) return nearest_facet(affine_coordinates(cell, x));
  Vector<dim> xi;
  if (newton_coordinates(cell, x, xi)) return nearest_facet(xi);
  Nearest nearest = nearest_facet(affine_coordinates(cell, x));  // for the direction only
  nearest.distance = -1.0;
  return nearest;
}

/// @returns the containing cell, or -1 when the walk gives up
template <int dim>
std::int32_t CellLocator<dim>::walk(const Vector<dim>& x, std::int32_t cell) const {
  for (int step = 0; step < max_walk && cell >= 0; ++step) {
    const Nearest nearest = nearest_facet(cell, x);
    const double tolerance = maps_[cell].tolerance;
    if (nearest.distance > tie_factor * tolerance) return cell;
    if (nearest.distance >= -tolerance) return -1;  // a neighbour may be the lower one
    cell = neighbours_[static_cast<std::size_t>(cell) * facets_per_cell_ + nearest.facet];
  }
  return -1;
}

template <int dim>
std::span<const std::int32_t> CellLocator<dim>::candidates(const Vector<dim>& x) const {
  const auto at = bin_of(x);
  int b = at[dim - 1];
  for (int i = dim - 2; i >= 0; --i) b = b * num_bins_[i] + at[i];
  return {bin_cells_.data() + bin_starts_[b],
          static_cast<std::size_t>(bin_starts_[b + 1] - bin_starts_[b])};
}

template <int dim>
bool CellLocator<dim>::contains(std::int32_t cell, const Vector<dim>& x) const {
  return nearest_facet(cell, x).distance >= -maps_[cell].tolerance;
}

template <int dim>
bool CellLocator<dim>::in_bounds(const Vector<dim>& x) const {
  for (int i = 0; i < dim; ++i) {  // written so that NaN is outside
    if (!(x[i] >= low_[i] && x[i] <= high_[i])) return false;
  }
  return true;
}

template <int dim>
std::int32_t CellLocator<dim>::search_bins(const Vector<dim>& x) const {
  for (const std::int32_t cell : candidates(x)) {
    if (contains(cell, x)) return cell;
  }
  return -1;
}

template <int dim>
std::vector<std::int32_t> CellLocator<dim>::cells_at(const Vector<dim>& x) const {
  std::vector<std::int32_t> cells;
  if (!in_bounds(x)) return cells;
  for (const std::int32_t cell : candidates(x)) {
    if (contains(cell, x)) cells.push_back(cell);
  }
  return cells;
}

template <int dim>
std::int32_t CellLocator<dim>::locate(const Vector<dim>& x, std::int32_t hint) const {
  if (!in_bounds(x)) return -1;
  if (hint >= 0 && hint < static_cast<std::int32_t>(maps_.size())) {
    const std::int32_t found = walk(x, hint);
    if (found >= 0) return found;
  }
  return search_bins(x);
}

template class CellLocator<2>;
template class CellLocator<3>;

}  // namespace gabion::mpm
