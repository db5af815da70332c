// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/mechanics/tensor.hpp"
#include "mpm_solver/contact/contact_settings.hpp"

namespace gabion::mpm {

/// A segment (2D) or triangle (3D) of a surface: its vertices, in the order that gives the normal
/// into the soil. Quadrilaterals are two triangles, along the diagonal that points more to the
/// middle of the surface.
template <int dim>
using Simplex = std::array<std::int32_t, dim>;

template <int dim>
std::vector<Simplex<dim>> simplices(const ContactSurface<dim>& surface);

/// Marks of the vertices: 1 where a vertex is on the rim of an open surface, an edge (2D: vertex)
/// that belongs to one simplex only.
template <int dim>
std::vector<char> rim_vertices(std::span<const Simplex<dim>> simplices, std::size_t num_vertices);

/// The simplices that share a side with one, by the corner that the side does not have.
template <int dim>
using Neighbours = std::array<std::int32_t, dim>;
constexpr std::int32_t no_neighbour = -1;
constexpr std::int32_t several_neighbours = -2;

template <int dim>
std::vector<Neighbours<dim>> neighbours_of(std::span<const Simplex<dim>> simplices);

/// Corners of a simplex, for vertices at these positions.
template <int dim>
std::array<Vector<dim>, dim> corners_of(const Simplex<dim>& simplex,
                                        std::span<const Vector<dim>> vertices) {
  std::array<Vector<dim>, dim> corners;
  for (int k = 0; k < dim; ++k) corners[k] = vertices[simplex[k]];
  return corners;
}

/// Normal of length 1 of a simplex with these corners.
template <int dim>
Vector<dim> simplex_normal(const std::array<Vector<dim>, dim>& corners);

/// The place of a simplex that is closest to y.
template <int dim>
struct ClosestPlace {
  std::array<double, dim> weights{};    ///< of the corners, >= 0
  Vector<dim> x = Vector<dim>::Zero();  ///< where it is [m]
  /// Number of corners with a weight: dim inside of the simplex, less on its edges and corners.
  int num_corners() const;
};

/// @see Ericson (2005), Real-time collision detection, section 5.1
template <int dim>
ClosestPlace<dim> closest_place(const std::array<Vector<dim>, dim>& corners, const Vector<dim>& y);

/// Weights of the corners at the foot of y on the line or plane of a simplex; < 0 beyond its sides.
template <int dim>
std::array<double, dim> weights_of_foot(const std::array<Vector<dim>, dim>& corners,
                                        const Vector<dim>& y);

/// A place of a surface where its distance to a point has a local minimum.
template <int dim>
struct SurfaceFeature {
  std::int32_t simplex = 0;
  std::array<double, dim> weights{};         ///< of its corners
  Vector<dim> x = Vector<dim>::Zero();       ///< where it is [m]
  Vector<dim> normal = Vector<dim>::Zero();  ///< from there to the point, of length 1
  double distance = 0;                       ///< [m], < 0: the point is behind the surface
};

/// Bounding sphere of a simplex, for a quick exclusion.
template <int dim>
struct SimplexBounds {
  Vector<dim> centre;  ///< of a sphere that holds it [m]
  double radius = 0;   ///< [m]
  Vector<dim> normal;

  /// Whether it surely is farther from x than this.
  bool is_beyond(const Vector<dim>& x, double distance) const {
    const double limit = radius + distance;
    return (x - centre).squaredNorm() > limit * limit;
  }
};

/// @param vertices  their positions [m]
template <int dim>
std::vector<SimplexBounds<dim>> bounds_of(std::span<const Simplex<dim>> simplices,
                                          std::span<const Vector<dim>> vertices);

/// A simplex that a point may meet in a step, seen from the point at the start of the step.
struct FacingSimplex {
  std::int32_t simplex = 0;
  bool touched = false;  ///< the point was in contact with the surface with about this normal
  double height = 0;     ///< of the point above its plane [m]; > 0 unless in contact
  double distance = 0;   ///< of the point, or less [m]
};

/// Two surfaces whose normals have at most this cosine (53 degrees), with the soil between them,
/// meet in a corner: they push independently.
constexpr double corner_cosine = 0.6;

/// Positions of the surface and the simplices that faced a point when a step began. A rim that
/// meets a simplex of this or another surface at the end of the step is no open edge. There the two
/// are one surface, with or without vertices in common, except where two surfaces meet in a corner,
/// see corner_cosine.
template <int dim>
struct FacingSurface {
  std::span<const Simplex<dim>> simplices;
  std::span<const Vector<dim>> start;  ///< of the vertices at the start of the step [m]
  std::span<const Vector<dim>> end;    ///< at its end [m]
  std::span<const FacingSimplex> facing;
  std::span<const char> rim{};  ///< of the vertices, see rim_vertices; empty: there is no rim
  std::span<const std::int32_t> owner{};  ///< surface of each simplex; empty: there is one only
  double motion = 0;                      ///< the largest of a vertex in the step [m]
  double size = 0;  ///< no two places of a simplex are farther from each other [m]
  double seam = 0;  ///< a rim that is nearer to a simplex meets it [m]
};

/// Distances within which a surface acts on a point.
struct FeatureReach {
  double distance = 0;  ///< features that are farther do not count [m]
  double radius = 0;    ///< of the contact sphere around the point [m]
};

/// Whether two simplices belong to different surfaces that meet in a corner there.
template <int dim>
bool are_in_corner(const FacingSurface<dim>& surface, std::int32_t a, std::int32_t b);

/// The features of a surface that are within reach of a point that came from x to y, or that its
/// displacement path went through. Re-entrant corners have several, each a little beyond the end of
/// its simplex, with the weights of the simplex that is next to it there. Where the point is behind
/// several features, only the one with the smallest penetration counts, with those that form
/// re-entrant corners with it. A point in contact whose centre went through the surface stays
/// behind it.
/// @param features  cleared first
template <int dim>
void find_features(const FacingSurface<dim>& surface, const Vector<dim>& x, const Vector<dim>& y,
                   const FeatureReach& reach, std::vector<SurfaceFeature<dim>>& features);

}  // namespace gabion::mpm
