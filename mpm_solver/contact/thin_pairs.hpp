// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "mpm_solver/contact/start_check.hpp"
#include "mpm_solver/contact/surface_features.hpp"

namespace gabion::mpm {

/// Two simplices with a structure between them.
struct FacePair {
  std::int32_t front, back;
  double thickness;  ///< [m]
};

/// All simplices of several surfaces, but those of the mode `fixed`, to which soil sticks on all
/// sides.
template <int dim>
struct Faces {
  std::vector<Vector<dim>> vertices;
  std::vector<Simplex<dim>> simplices;
  std::vector<std::size_t> surface;                        ///< of each simplex
  std::vector<std::int32_t> first_simplex, num_simplices;  ///< of each surface
  std::vector<std::int32_t> first_vertex;                  ///< of each surface
  std::vector<SimplexBounds<dim>> bounds;

  explicit Faces(const std::vector<StartSurface<dim>>& surfaces);
  /// Whether both faces belong to surfaces of the method `facets`, which SideFields knows.
  /// @param surfaces  as the constructor got them
  bool can_have_fields(const FacePair& pair, const std::vector<StartSurface<dim>>& surfaces) const;
  /// Set the vertices of a surface. @returns whether they were elsewhere
  bool move(std::size_t surface_number, std::span<const Vector<dim>> x) {
    const auto own = vertices.begin() + first_vertex[surface_number];
    if (std::equal(x.begin(), x.end(), own)) return false;
    std::copy(x.begin(), x.end(), own);
    return true;
  }
  Vector<dim> closest(std::int32_t s, const Vector<dim>& x) const {
    return closest_place<dim>(corners_of<dim>(simplices[s], vertices), x).x;
  }
};

/// Pairs of faces thinner than two cells, seen from the centre of the front: functions of a cell
/// reach over the next one, so soil on both sides of such a wall would share nodes.
/// @param cell_size  mean [m]
template <int dim>
std::vector<FacePair> thin_pairs(const Faces<dim>& faces, double cell_size);

/// The simplices that are in pairs, ascending.
std::vector<std::int32_t> members(const std::vector<FacePair>& pairs);

}  // namespace gabion::mpm
