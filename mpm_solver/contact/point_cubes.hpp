// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include "common/mechanics/tensor.hpp"

namespace gabion::mpm {

/// Places that are found by the cubes of a lattice around them all. Refers to the places.
template <int dim>
class PointCubes {
 public:
  using Box = Eigen::AlignedBox<double, dim>;

  /// @param edge  wanted edge of a cube [m]; there are no more cubes than some for each place
  PointCubes(const std::vector<Vector<dim>>& places, double edge) : places_(places), size_(edge) {
    if (places_.empty()) return;
    Box around;
    for (const Vector<dim>& x : places_) around.extend(x);
    low_ = around.min();
    constexpr double most_a_place = 4;
    const double most = most_a_place * static_cast<double>(places_.size());
    while ((1 + (around.sizes() / size_).array().floor()).prod() > most) size_ *= 2;
    for (int d = 0; d < dim; ++d) counts_[d] = 1 + index(around.max()[d], d);
    std::int64_t count = 1;
    for (const std::int64_t n : counts_) count *= n;
    starts_.assign(static_cast<std::size_t>(count) + 1, 0);
    for (const Vector<dim>& x : places_) ++starts_[cube_of(x) + 1];
    std::partial_sum(starts_.begin(), starts_.end(), starts_.begin());
    sorted_.resize(places_.size());
    std::vector<std::int32_t> next(starts_.begin(), starts_.end() - 1);
    for (std::int32_t p = 0; p < size(); ++p) sorted_[next[cube_of(places_[p])]++] = p;
  }

  std::int32_t size() const { return static_cast<std::int32_t>(places_.size()); }

  /// Call with the number and the place of each that is in a box widened by a distance [m], and of
  /// some more.
  template <class Function>
  void for_near(const Box& box, double distance, const Function& call) const {
    if (places_.empty()) return;
    std::array<std::int64_t, dim> first, last;
    for (int d = 0; d < dim; ++d) {
      first[d] = std::max<std::int64_t>(0, index(box.min()[d] - distance, d) - 1);
      last[d] = std::min(counts_[d] - 1, index(box.max()[d] + distance, d) + 1);
      if (first[d] > last[d]) return;
    }
    auto cube = first;
    while (true) {
      const std::size_t c = number(cube);
      for (std::int32_t i = starts_[c]; i < starts_[c + 1]; ++i) {
        call(sorted_[i], places_[sorted_[i]]);
      }
      int d = 0;
      for (; d < dim && cube[d] == last[d]; ++d) cube[d] = first[d];
      if (d == dim) return;
      ++cube[d];
    }
  }

 private:
  // Of a cube along an axis; places far out of the lattice have a number just out of it.
  std::int64_t index(double x, int d) const {
    const double far = static_cast<double>(places_.size()) * 8 + 8;
    return static_cast<std::int64_t>(std::clamp(std::floor((x - low_[d]) / size_), -8.0, far));
  }
  std::size_t number(const std::array<std::int64_t, dim>& cube) const {
    std::int64_t result = 0;
    for (int d = dim - 1; d >= 0; --d) result = result * counts_[d] + cube[d];
    return static_cast<std::size_t>(result);
  }
  std::size_t cube_of(const Vector<dim>& x) const {
    std::array<std::int64_t, dim> cube;
    for (int d = 0; d < dim; ++d) cube[d] = std::min(counts_[d] - 1, index(x[d], d));
    return number(cube);
  }

  const std::vector<Vector<dim>>& places_;
  double size_;
  Vector<dim> low_ = Vector<dim>::Zero();
  std::array<std::int64_t, dim> counts_{};
  std::vector<std::int32_t> starts_, sorted_;
};

}  // namespace gabion::mpm
