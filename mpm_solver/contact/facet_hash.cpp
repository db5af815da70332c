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
FacetHash<dim>::FacetHash(std::span<const Simplex<dim>> simplices,
                          std::span<const Vector<dim>> vertices, double margin) {
  low_.setConstant(std::numeric_limits<double>::infinity());
  high_ = -low_;
  struct Box {
    Vector<dim> low, high;
  };
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
    low_ = low_.cwiseMin(box.low);
    high_ = high_.cwiseMax(box.high);
    boxes.push_back(box);
  }
  size_ =
      std::max(2 * margin, widest / static_cast<double>(std::max<std::size_t>(1, boxes.size())));
  for (std::size_t s = 0; s < boxes.size(); ++s) {
    const Cube first = cube_of(boxes[s].low), last = cube_of(boxes[s].high);
    Cube cube = first;
    while (true) {
      cubes_[cube].push_back(static_cast<std::int32_t>(s));
      int d = 0;
      for (; d < dim && cube[d] == last[d]; ++d) cube[d] = first[d];
      if (d == dim) break;
      ++cube[d];
    }
  }
}

template <int dim>
std::span<const std::int32_t> FacetHash<dim>::near(const Vector<dim>& x) const {
  if ((x.array() < low_.array()).any() || (x.array() > high_.array()).any()) return {};
  const auto found = cubes_.find(cube_of(x));
  if (found == cubes_.end()) return {};
  return found->second;
}

template class FacetHash<2>;
template class FacetHash<3>;

}  // namespace gabion::mpm
