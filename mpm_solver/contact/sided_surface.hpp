// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "mpm_solver/contact/facet_hash.hpp"
#include "mpm_solver/points/material_points.hpp"

namespace gabion::mpm {

/// Distances that differ by less than this share are equal.
inline constexpr double same_distance = 1e-9;

/// Share of its radius by which a contact sphere may lie behind facets, since those of a curved
/// surface bulge.
inline constexpr double allowed_overlap = 0.05;

/// Side of a surface on which a place lies.
struct SurfaceSide {
  double distance = std::numeric_limits<double>::infinity();  ///< [m]
  double height = 0;                                          ///< above the nearest simplex [m]
  bool beyond_rim = false;

  bool known() const { return std::isfinite(distance) && (height > 0 || !beyond_rim); }
  bool in_front() const { return height > 0; }
};

/// A surface at rest that tells on which side a place is.
template <int dim>
class SidedSurface {
 public:
  /// @param vertices  their places [m]
  /// @param reach     places that are farther from the surface may have no known side [m]
  SidedSurface(const ContactSurface<dim>& surface, std::vector<Vector<dim>> vertices, double reach);

  /// The side of the nearest simplex. Where several are equally near, since they meet in an edge,
  /// the one whose plane is farthest from the place decides: its side is the right one.
  /// @param within  simplices that are farther may be left out [m]
  SurfaceSide side(const Vector<dim>& x,
                   double within = std::numeric_limits<double>::infinity()) const;

 private:
  SurfaceSide side_of(std::int32_t s, const Vector<dim>& x) const;

  std::vector<Vector<dim>> vertices_;
  std::vector<Simplex<dim>> simplices_;
  std::vector<SimplexBounds<dim>> bounds_;
  std::vector<char> rim_;  // 1 for vertices on the rim of an open surface
  FacetHash<dim> hash_;
};

/// The contact sphere of a material point at the start.
template <int dim>
struct StartSphere {
  Vector<dim> x;
  double radius;  ///< [m]
  double size;    ///< edge of a square or cube of the point's volume [m]
};

template <int dim>
StartSphere<dim> start_sphere(const MaterialPoints<dim>& points, std::int32_t p);

/// Depth of a contact sphere behind a surface of a structure [m]; empty: no deeper than allowed.
/// @param side      of the sphere's centre, known
/// @param measured  the method of contact measures distances from the front
template <int dim>
std::optional<double> depth_inside(const StartSphere<dim>& sphere, const SurfaceSide& side,
                                   bool measured);

}  // namespace gabion::mpm
