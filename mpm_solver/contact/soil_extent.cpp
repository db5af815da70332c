// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/soil_extent.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/mechanics/ranks/sum.hpp"

namespace gabion::mpm {

namespace {

// A search that would look at more than this share of the cubes looks at all groups instead.
constexpr double most_cubes = 0.25;

template <int dim>
double largest_norm(const std::vector<Vector<dim>>& values) {
  double largest = 0;
  for (const auto& v : values) largest = std::max(largest, v.norm());
  return largest;
}

}  // namespace

template <int dim>
SoilExtent<dim>::SoilExtent(const SoilSurface<dim>& soil)
    : points_(soil.points), weights_(soil.weights) {
  double all[] = {std::max(largest_norm<dim>(soil.points.v), largest_norm<dim>(soil.nodes.v)), 0};
  for (std::int32_t p = 0; p < soil.points.size(); ++p) {
    all[1] = std::max(all[1], soil.points.V0[p] * soil.points.J[p]);
    all_.extend(soil.points.x[p]);
  }
  max_over_ranks(soil.comm, std::span<double>(all));
  fastest_ = all[0];
  widest_ = cube_side<dim>(all[1]);
}

template <int dim>
typename SoilExtent<dim>::Index SoilExtent<dim>::cube_of(const Vector<dim>& x) const {
  Index cube;
  for (int d = 0; d < dim; ++d) cube[d] = static_cast<std::int64_t>(std::floor(x[d] / cube_));
  return cube;
}

template <int dim>
void SoilExtent<dim>::find_boxes() const {
  if (!boxes_.empty()) return;
  boxes_.resize(weights_.groups.size());
  for (std::size_t g = 0; g < boxes_.size(); ++g) {
    const CellGroup& group = weights_.groups[g];
    for (std::int32_t e = group.first; e < group.last; ++e) {
      boxes_[g].extend(points_.x[weights_.point[e]]);
    }
    if (!boxes_[g].isEmpty()) half_ = half_.cwiseMax(0.5 * boxes_[g].sizes());
  }
  cube_ = std::max(2 * half_.maxCoeff(), widest_);
  std::vector<std::int32_t> of_group(boxes_.size(), -1), counts;
  for (std::size_t g = 0; g < boxes_.size(); ++g) {
    if (boxes_[g].isEmpty()) continue;
    of_group[g] = cubes_.add(cube_of(boxes_[g].center()));
    counts.resize(static_cast<std::size_t>(cubes_.size()));
    ++counts[of_group[g]];
  }
  starts_.assign(counts.size() + 1, 0);
  std::partial_sum(counts.begin(), counts.end(), starts_.begin() + 1);
  in_cubes_.resize(static_cast<std::size_t>(starts_.back()));
  std::vector<std::int32_t> next(starts_.begin(), starts_.end() - 1);
  for (std::size_t g = 0; g < boxes_.size(); ++g) {
    if (of_group[g] >= 0) in_cubes_[next[of_group[g]]++] = static_cast<std::int32_t>(g);
  }
}

template <int dim>
std::vector<std::int32_t> SoilExtent<dim>::groups_in(const Box& box) const {
  std::vector<std::int32_t> groups;
  const auto take_all = [&] {
    groups.resize(weights_.groups.size());
    std::iota(groups.begin(), groups.end(), 0);
  };
  if (all_.isEmpty() || !box.intersects(all_)) return groups;
  if (box.contains(all_)) {
    take_all();
    return groups;
  }
  find_boxes();
  const Box part = box.intersection(all_);
  const Vector<dim> low = part.min() - half_, high = part.max() + half_;
  const auto is_apart = [&](std::int32_t g) { return !boxes_[g].intersects(box); };
  if (((high - low) / cube_).array().ceil().prod() > most_cubes * cubes_.size()) {
    take_all();
    std::erase_if(groups, is_apart);
    return groups;
  }
  const Index first = cube_of(low), last = cube_of(high);
  Index cube = first;
  while (true) {
    if (const std::int32_t k = cubes_.find(cube); k >= 0) {
      groups.insert(groups.end(), in_cubes_.begin() + starts_[k],
                    in_cubes_.begin() + starts_[k + 1]);
    }
    int d = 0;
    for (; d < dim && cube[d] == last[d]; ++d) cube[d] = first[d];
    if (d == dim) break;
    ++cube[d];
  }
  std::erase_if(groups, is_apart);
  std::ranges::sort(groups);
  return groups;
}

template class SoilExtent<2>;
template class SoilExtent<3>;

}  // namespace gabion::mpm
