// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/facet_hash.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gabion::mpm {

template <int dim>
std::size_t FacetHash<dim>::CubeHash::operator()(const Cube& cube) const {
  std::size_t hash = 0;
  for (const std::int64_t k : cube) {
    hash = (hash ^ static_cast<std::size_t>(k)) * std::size_t{0x9E3779B97F4A7C15};
  }
  return hash ^ (hash >> 29);
}

template <int dim>
typename FacetHash<dim>::Cube FacetHash<dim>::cube_of(const Vector<dim>& x) const {
  Cube cube;
  for (int d = 0; d < dim; ++d) cube[d] = static_cast<std::int64_t>(std::floor(x[d] / size_));
  return cube;
}

template <int dim>
void FacetHash<dim>::list(std::int32_t simplex, const Box& box, bool in_known_cubes) {
  const Cube first = cube_of(box.low), last = cube_of(box.high);
  Cube cube = first;
  while (true) {
    const auto known = in_known_cubes ? cubes_.find(cube) : cubes_.try_emplace(cube).first;
    if (known != cubes_.end()) {
      known->second.push_back(simplex);
      ++num_listed_;
    }
    int d = 0;
    for (; d < dim && cube[d] == last[d]; ++d) cube[d] = first[d];
    if (d == dim) break;
    ++cube[d];
  }
}

template <int dim>
typename FacetHash<dim>::Box FacetHash<dim>::everywhere() {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  return {Vector<dim>::Constant(-infinity), Vector<dim>::Constant(infinity)};
}

template <int dim>
typename FacetHash<dim>::Box FacetHash<dim>::box_around(std::span<const Vector<dim>> places) {
  const auto [low, high] = everywhere();
  Box box{high, low};
  for (const Vector<dim>& x : places) {
    box.low = box.low.cwiseMin(x);
    box.high = box.high.cwiseMax(x);
  }
  return box;
}

template <int dim>
FacetHash<dim>::FacetHash(std::span<const Simplex<dim>> simplices,
                          std::span<const Vector<dim>> vertices, double margin,
                          const std::span<const Vector<dim>>* places, const Box& around) {
  std::vector<Box> boxes;
  double widest = 0;
  for (const Simplex<dim>& simplex : simplices) {
    Box box{vertices[simplex[0]], vertices[simplex[0]]};
    for (const std::int32_t v : simplex) {
      box.low = box.low.cwiseMin(vertices[v]);
      box.high = box.high.cwiseMax(vertices[v]);
    }
    widest += (box.high - box.low).maxCoeff();
    box.low.array() -= margin;
    box.high.array() += margin;
    boxes.push_back(box);
  }
  size_ =
      std::max(2 * margin, widest / static_cast<double>(std::max<std::size_t>(1, boxes.size())));
  if (places) {
    for (const Vector<dim>& x : *places) cubes_.try_emplace(cube_of(x));
  }
  for (std::size_t s = 0; s < boxes.size(); ++s) {
    const Box& box = boxes[s];
    const bool apart = (box.high.array() < around.low.array()).any() ||
                       (box.low.array() > around.high.array()).any();
    if (!apart) list(static_cast<std::int32_t>(s), box, places != nullptr);
  }
}

template <int dim>
std::span<const std::int32_t> FacetHash<dim>::near(const Vector<dim>& x) const {
  const auto found = cubes_.find(cube_of(x));
  if (found == cubes_.end()) return {};
  return found->second;
}

template class FacetHash<2>;
template class FacetHash<3>;

}  // namespace gabion::mpm
