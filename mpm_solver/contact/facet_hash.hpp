// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "mpm_solver/contact/surface_features.hpp"

namespace gabion::mpm {

/// Finds the simplices near a place: each is listed in all cubes of a hashed grid that its bounding
/// box meets.
template <int dim>
class FacetHash {
 public:
  struct Box {
    Vector<dim> low, high;
  };
  /// @param margin  the bounding boxes are widened by this much [m], > 0
  FacetHash(std::span<const Simplex<dim>> simplices, std::span<const Vector<dim>> vertices,
            double margin)
      : FacetHash(simplices, vertices, margin, nullptr, everywhere()) {}

  /// A hash for queries at these places only [m]: simplices far from all of them are not listed,
  /// and cost no more than a test of their bounding box.
  FacetHash(std::span<const Simplex<dim>> simplices, std::span<const Vector<dim>> vertices,
            double margin, std::span<const Vector<dim>> places)
      : FacetHash(simplices, vertices, margin, places, box_around(places)) {}

  /// A hash for one of several searches: simplices near a place do not depend on the search that
  /// asks. @param around  the places of all searches
  FacetHash(std::span<const Simplex<dim>> simplices, std::span<const Vector<dim>> vertices,
            double margin, std::span<const Vector<dim>> places, const Box& around)
      : FacetHash(simplices, vertices, margin, &places, around) {}

  /// Simplices whose widened bounding box may hold x.
  std::span<const std::int32_t> near(const Vector<dim>& x) const;

  /// Entries of all lists: what it costs to make them.
  std::size_t num_listed() const { return num_listed_; }

 private:
  FacetHash(std::span<const Simplex<dim>> simplices, std::span<const Vector<dim>> vertices,
            double margin, const std::span<const Vector<dim>>* places, const Box& around);
  static Box everywhere();
  static Box box_around(std::span<const Vector<dim>> places);
  void list(std::int32_t simplex, const Box& box, bool in_known_cubes);
  using Cube = std::array<std::int64_t, dim>;
  struct CubeHash {
    std::size_t operator()(const Cube& cube) const;
  };
  Cube cube_of(const Vector<dim>& x) const;

  double size_ = 1;
  std::size_t num_listed_ = 0;
  std::unordered_map<Cube, std::vector<std::int32_t>, CubeHash> cubes_;
};

}  // namespace gabion::mpm
