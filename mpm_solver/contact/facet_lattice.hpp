// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mpm_solver/contact/index_table.hpp"
#include "mpm_solver/contact/surface_features.hpp"

namespace gabion::mpm {

/// A surface for a FacetLattice, at its present place.
template <int dim>
struct LatticeSurface {
  std::span<const Simplex<dim>> simplices;
  std::int32_t first = 0;                      ///< number that the first simplex has in lists
  std::span<const Vector<dim>> vertices;       ///< present positions [m]
  std::span<const SimplexBounds<dim>> bounds;  ///< of the simplices, at these positions
};

/// Finds the simplices of a surface near a place, step after step: lists of the cubes of a lattice,
/// each made when it is first asked for and kept until the surface has moved too far. The simplices
/// found within a distance do not depend on when the lists were made.
template <int dim>
class FacetLattice {
 public:
  struct Sizes {
    double cube = 0;         ///< edge of the cubes [m]
    double reach = 0;        ///< a list has all simplices within this distance of its cube [m]
    double slack = 0;        ///< the surface may move by this much in all [m]
    bool with_lists = true;  ///< else for `at_least` alone
  };
  FacetLattice() = default;
  FacetLattice(const LatticeSurface<dim>& surface, const Sizes& sizes);

  const Sizes& sizes() const { return sizes_; }
  /// A vertex moved by as much as this [m].
  void add_motion(double path) { moved_ += path; }
  /// Whether the surface moved too far since the lattice was made.
  bool is_stale() const { return !(moved_ <= sizes_.slack); }

  /// Simplices near x, ascending: all within `distance` of it [m], and others. The list is valid
  /// until the next call of a function of the lattice.
  /// @param[out] room  for a list that is not kept
  std::span<const std::int32_t> near(const LatticeSurface<dim>& surface, const Vector<dim>& x,
                                     double distance, std::vector<std::int32_t>& room) const;

  /// A distance that no place of the surface is nearer to any place of a box [m]; may be < 0.
  /// @param half  half lengths of the box along the axes [m]
  double at_least(const LatticeSurface<dim>& surface, const Vector<dim>& middle,
                  const Vector<dim>& half) const;

 private:
  using Index = typename IndexTable<dim>::Key;
  /// Entry of a cube: its list, and a plane that no simplex of it is beyond.
  struct Cube {
    std::size_t first = 0, count = 0;
    Vector<dim> normal = Vector<dim>::Zero();
    double height = 0;  // normal . x <= height for all places of listed simplices
  };
  struct Box {
    Vector<dim> low, high;
  };
  double num_bins(const Box& box) const;
  static Box box_of(const LatticeSurface<dim>& surface, std::int32_t simplex);
  void gather(const Box& box, std::vector<std::int32_t>& found) const;
  double height_along(const LatticeSurface<dim>& surface, const Vector<dim>& normal) const;
  const Cube& cube_around(const LatticeSurface<dim>& surface, const Vector<dim>& x) const;
  Cube make(const LatticeSurface<dim>& surface, const Index& index) const;

  Sizes sizes_;
  std::int32_t first_ = 0;
  std::size_t num_simplices_ = 0;
  double moved_ = 0;      // since it was made [m]
  double bin_size_ = 0;   // [m]
  IndexTable<dim> bins_;  // those that boxes around simplices meet
  std::vector<std::int32_t> bin_starts_, in_bins_;
  std::vector<std::int32_t> large_;  // simplices that are in no bin, since they meet many
  // kept answers
  mutable IndexTable<dim> known_;
  mutable std::vector<Cube> cubes_;
  mutable std::vector<std::int32_t> lists_;
  mutable std::vector<std::int32_t> found_;  // room
};

}  // namespace gabion::mpm
