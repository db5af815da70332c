// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "mpm_solver/contact/surface_features.hpp"

namespace gabion::mpm {

/// Finds the simplices near a place: each is listed in all cubes of a hashed grid that its bounding
/// box touches.
template <int dim>
class FacetHash {
 public:
  /// @param margin  the bounding boxes are widened by this much [m], > 0
  FacetHash(std::span<const Simplex<dim>> simplices, std::span<const Vector<dim>> vertices,
            double margin);

  /// Those whose widened bounding box may hold x.
  std::span<const std::int32_t> near(const Vector<dim>& x) const;

 private:
  using Cube = std::array<std::int64_t, dim>;
  struct CubeHash {
    std::size_t operator()(const Cube& cube) const;
  };
  Cube cube_of(const Vector<dim>& x) const;

  double size_ = 1;
  Vector<dim> low_, high_;
  std::unordered_map<Cube, std::vector<std::int32_t>, CubeHash> cubes_;
};

}  // namespace gabion::mpm
