// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/facet_lattice.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace gabion::mpm {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// A simplex whose box meets more bins than this is in none and is always looked at: the bins of a
// slope of few triangles would fill the memory.
constexpr double most_bins = 1000;

template <int dim>
using CubeIndex = typename IndexTable<dim>::Key;

// The cube of a lattice that holds x: its place along each axis, in cubes from the origin.
template <int dim>
CubeIndex<dim> cube_at(const Vector<dim>& x, double size) {
  CubeIndex<dim> cube;
  for (int d = 0; d < dim; ++d) cube[d] = static_cast<std::int64_t>(std::floor(x[d] / size));
  return cube;
}

// Call visit(cube) for all cubes that a box meets.
template <int dim, typename Visit>
void for_each_cube(const Vector<dim>& low, const Vector<dim>& high, double size, Visit&& visit) {
  const CubeIndex<dim> first = cube_at<dim>(low, size), last = cube_at<dim>(high, size);
  CubeIndex<dim> cube = first;
  while (true) {
    visit(cube);
    int d = 0;
    for (; d < dim && cube[d] == last[d]; ++d) cube[d] = first[d];
    if (d == dim) break;
    ++cube[d];
  }
}

// Sort a list in ascending order, each entry once.
void keep_once(std::vector<std::int32_t>& list) {
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

}  // namespace

template <int dim>
typename FacetLattice<dim>::Box FacetLattice<dim>::box_of(const LatticeSurface<dim>& surface,
                                                          std::int32_t simplex) {
  const Simplex<dim>& corners = surface.simplices[simplex - surface.first];
  Box box{surface.vertices[corners[0]], surface.vertices[corners[0]]};
  for (int k = 1; k < dim; ++k) {
    box.low = box.low.cwiseMin(surface.vertices[corners[k]]);
    box.high = box.high.cwiseMax(surface.vertices[corners[k]]);
  }
  return box;
}

template <int dim>
FacetLattice<dim>::FacetLattice(const LatticeSurface<dim>& surface, const Sizes& sizes)
    : sizes_(sizes),
      first_(surface.first),
      num_simplices_(surface.simplices.size()),
      bin_size_(sizes.cube + sizes.reach) {
  const auto count = static_cast<std::int32_t>(surface.simplices.size());
  std::vector<std::int32_t> counts;
  const auto for_each_bin = [&](std::int32_t simplex, auto&& visit) {
    const Box box = box_of(surface, simplex);
    if (num_bins(box) > most_bins) return;
    for_each_cube<dim>(box.low, box.high, bin_size_, visit);
  };
  for (std::int32_t s = surface.first; s < surface.first + count; ++s) {
    if (num_bins(box_of(surface, s)) > most_bins) large_.push_back(s);
  }
  for (std::int32_t s = surface.first; s < surface.first + count; ++s) {
    for_each_bin(s, [&](const CubeIndex<dim>& index) {
      const auto bin = static_cast<std::size_t>(bins_.add(index));
      if (bin == counts.size()) counts.push_back(0);
      ++counts[bin];
    });
  }
  bin_starts_.assign(counts.size() + 1, 0);
  for (std::size_t b = 0; b < counts.size(); ++b) bin_starts_[b + 1] = bin_starts_[b] + counts[b];
  in_bins_.resize(static_cast<std::size_t>(bin_starts_.back()));
  std::vector<std::int32_t> next(bin_starts_.begin(), bin_starts_.end() - 1);
  for (std::int32_t s = surface.first; s < surface.first + count; ++s) {
    for_each_bin(s, [&](const CubeIndex<dim>& index) { in_bins_[next[bins_.find(index)]++] = s; });
  }
}

// The number of bins that a box meets, exact to one along each axis.
template <int dim>
double FacetLattice<dim>::num_bins(const Box& box) const {
  return (((box.high - box.low) / bin_size_).array().floor() + 1).prod();
}

// Simplices in the bins that a box meets, some several times, and large ones; all simplices where
// that is no more work.
template <int dim>
void FacetLattice<dim>::gather(const Box& box, std::vector<std::int32_t>& found) const {
  found = large_;
  const Vector<dim> bins = (box.high - box.low) / bin_size_;
  if (!((bins.array() + 1).prod() < bins_.size())) {
    found.resize(num_simplices_);
    std::iota(found.begin(), found.end(), first_);
    return;
  }
  for_each_cube<dim>(box.low, box.high, bin_size_, [&](const CubeIndex<dim>& index) {
    const std::int32_t bin = bins_.find(index);
    if (bin < 0) return;
    found.insert(found.end(), in_bins_.begin() + bin_starts_[bin],
                 in_bins_.begin() + bin_starts_[bin + 1]);
  });
}

// Extent of the simplices of found_ along a normal.
template <int dim>
double FacetLattice<dim>::height_along(const LatticeSurface<dim>& surface,
                                       const Vector<dim>& normal) const {
  double height = -infinity;
  for (const std::int32_t s : found_) {
    const SimplexBounds<dim>& bounds = surface.bounds[s - surface.first];
    if (normal.dot(bounds.centre) + bounds.radius < height) continue;
    for (const std::int32_t v : surface.simplices[s - surface.first]) {
      height = std::max(height, normal.dot(surface.vertices[v]));
    }
  }
  return height;
}

// The plane is the one of two that is farther from the middle of the cube: across the mean normal
// of the simplices, or across the direction to the nearest one.
template <int dim>
typename FacetLattice<dim>::Cube FacetLattice<dim>::make(const LatticeSurface<dim>& surface,
                                                         const Index& index) const {
  Vector<dim> low;
  for (int d = 0; d < dim; ++d) low[d] = static_cast<double>(index[d]) * sizes_.cube;
  const Vector<dim> high = (low.array() + sizes_.cube).matrix(), middle = 0.5 * (low + high);
  const double around = sizes_.reach + sizes_.slack;
  const double in_bins = around + sizes_.slack;  // bins know where the simplices were
  gather({(low.array() - in_bins).matrix(), (high.array() + in_bins).matrix()}, found_);
  const double corner = 0.5 * (high - low).norm();
  std::erase_if(found_, [&](std::int32_t s) {
    const SimplexBounds<dim>& bounds = surface.bounds[s - surface.first];
    if (bounds.is_beyond(middle, around + corner)) return true;
    const Vector<dim> outside = bounds.centre - bounds.centre.cwiseMax(low).cwiseMin(high);
    const double limit = bounds.radius + around;
    if (outside.squaredNorm() > limit * limit) return true;
    const Box box = box_of(surface, s);
    const Vector<dim> apart =
        (box.low - high).cwiseMax(low - box.high).cwiseMax(Vector<dim>::Zero());
    return apart.squaredNorm() > around * around;
  });
  keep_once(found_);
  Vector<dim> mean = Vector<dim>::Zero(), away = mean;
  double nearest = infinity;
  for (const std::int32_t s : found_) {
    const SimplexBounds<dim>& bounds = surface.bounds[s - surface.first];
    mean += bounds.normal;
    if (bounds.is_beyond(middle, nearest)) continue;
    const auto corners = corners_of<dim>(surface.simplices[s - surface.first], surface.vertices);
    const Vector<dim> path = middle - closest_place<dim>(corners, middle).x;
    if (path.norm() >= nearest) continue;
    nearest = path.norm();
    away = path;
  }
  Cube cube{.first = lists_.size(), .height = found_.empty() ? -infinity : infinity};
  double farthest = -infinity;
  for (const Vector<dim>& direction : {mean, away}) {
    if (!(direction.norm() > 0)) continue;
    const Vector<dim> normal = direction.normalized();
    const double height = height_along(surface, normal);
    if (normal.dot(middle) - height <= farthest) continue;
    farthest = normal.dot(middle) - height;
    cube.normal = normal;
    cube.height = height;
  }
  if (sizes_.with_lists) lists_.insert(lists_.end(), found_.begin(), found_.end());
  cube.count = lists_.size() - cube.first;
  return cube;
}

template <int dim>
const typename FacetLattice<dim>::Cube& FacetLattice<dim>::cube_around(
    const LatticeSurface<dim>& surface, const Vector<dim>& x) const {
  const CubeIndex<dim> index = cube_at<dim>(x, sizes_.cube);
  const std::int32_t known = known_.find(index);
  if (known >= 0) return cubes_[static_cast<std::size_t>(known)];
  const Cube cube = make(surface, index);
  known_.add(index);
  return cubes_.emplace_back(cube);
}

template <int dim>
std::span<const std::int32_t> FacetLattice<dim>::near(const LatticeSurface<dim>& surface,
                                                      const Vector<dim>& x, double distance,
                                                      std::vector<std::int32_t>& room) const {
  if (distance <= sizes_.reach) {
    const Cube& cube = cube_around(surface, x);
    return std::span(lists_).subspan(cube.first, cube.count);
  }
  const double around = distance + sizes_.slack;
  gather({(x.array() - around).matrix(), (x.array() + around).matrix()}, room);
  keep_once(room);
  return room;
}

template <int dim>
double FacetLattice<dim>::at_least(const LatticeSurface<dim>& surface, const Vector<dim>& middle,
                                   const Vector<dim>& half) const {
  const Cube& cube = cube_around(surface, middle);
  const double above =
      cube.normal.dot(middle) - cube.normal.cwiseAbs().dot(half) - cube.height - moved_;
  return std::min(sizes_.reach - half.norm(), above);
}

template class FacetLattice<2>;
template class FacetLattice<3>;

}  // namespace gabion::mpm
