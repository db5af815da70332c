// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "mpm_solver/contact/point_cubes.hpp"
#include "mpm_solver/contact/start_check.hpp"

namespace gabion::mpm {

template <int dim>
Eigen::AlignedBox<double, dim> box_around(const std::vector<Vector<dim>>& vertices) {
  Eigen::AlignedBox<double, dim> box;
  for (const Vector<dim>& x : vertices) box.extend(x);
  return box;
}

/// Surfaces that a point may be near to, ascending.
class NearSurfaces {
 public:
  /// @param always  surfaces that every point is asked for, ascending
  /// @param hits    [point, surface] of the others, ascending in the surface
  NearSurfaces(std::vector<std::int32_t> always, std::span<const std::array<std::int32_t, 2>> hits,
               std::int32_t num_points)
      : always_(std::move(always)), starts_(static_cast<std::size_t>(num_points) + 1, 0) {
    for (const auto& [p, k] : hits) ++starts_[p + 1];
    std::partial_sum(starts_.begin(), starts_.end(), starts_.begin());
    others_.resize(hits.size());
    std::vector<std::size_t> next(starts_.begin(), starts_.end() - 1);
    for (const auto& [p, k] : hits) others_[next[p]++] = k;
  }
  void of_point(std::int32_t p, std::vector<std::int32_t>& surfaces) const {
    surfaces.clear();
    std::ranges::merge(always_, std::span(others_).subspan(starts_[p], starts_[p + 1] - starts_[p]),
                       std::back_inserter(surfaces));
  }

 private:
  std::vector<std::int32_t> always_, others_;
  std::vector<std::size_t> starts_;
};

/// Soil farther than `reach` from a boulder's box does not meet it.
template <int dim>
NearSurfaces near_surfaces(const std::vector<StartSurface<dim>>& surfaces,
                           const PointCubes<dim>& points, double reach) {
  std::vector<std::int32_t> always;
  std::vector<std::array<std::int32_t, 2>> hits;
  for (std::int32_t k = 0; k < std::ssize(surfaces); ++k) {
    if (!surfaces[k].is_boulder) {
      always.push_back(k);
      continue;
    }
    const auto box = box_around<dim>(surfaces[k].vertices);
    points.for_near(box, reach, [&](std::int32_t p, const Vector<dim>& x) {
      if (box.squaredExteriorDistance(x) <= reach * reach) hits.push_back({p, k});
    });
  }
  return {std::move(always), hits, points.size()};
}

}  // namespace gabion::mpm
