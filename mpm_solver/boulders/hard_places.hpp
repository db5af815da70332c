// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <span>
#include <vector>

#include "common/mechanics/tensor.hpp"

namespace gabion::mpm {

/// Corners of a segment (in the plane) or a triangle.
struct HardCorners {
  std::array<Vector<3>, 3> x{};
  int count = 3;
  Vector<3> normal() const;  ///< of length 1, out of what has the facet
};

HardCorners middle(const HardCorners& a, const HardCorners& b);

/// The place of a facet that is nearest to a point.
struct HardFoot {
  std::array<double, 3> weights{};  ///< of the corners
  int support = 0;         ///< number of corners that the place is between: all: above the face
  bool on_border = false;  ///< a corner has no weight
  int count = 3;           ///< of corners
  bool is_face() const { return support == count; }
};

HardFoot foot_of(const HardCorners& corners, const Vector<3>& y);
Vector<3> place_of(const HardFoot& foot, const HardCorners& corners);

/// No point of the facet is nearer to y than this.
double distance_at_least(const HardCorners& corners, const Vector<3>& y);

/// The place of a surface that is nearest to a point, with the signed distance to it: continuous
/// wherever the point goes, but for the free border of an open surface.
struct HardNearest {
  /// Negative behind the surface; infinite without facets and behind a free edge [m]
  double gap = std::numeric_limits<double>::infinity();
  std::int32_t facet = -1;
  HardFoot foot;                      ///< a border of a face is no face here
  Vector<3> out = Vector<3>::Zero();  ///< of length 1, the gradient of the gap
};

HardNearest nearest_of(std::span<const HardCorners> facets, const Vector<3>& y);

/// Distances at the start and at the end of a displacement, and the direction with normal .
/// (relative displacement) = g1 - g0.
struct HardGap {
  double g0 = 0, g1 = 0;
  Vector<3> normal = Vector<3>::Zero();
};

/// The direction that does so, if the nearest of a facet stays so.
/// @param y  at the start and at the end
Vector<3> mean_normal(const HardNearest& nearest, const HardCorners& start, const HardCorners& end,
                      const std::array<Vector<3>, 2>& y);
/// A direction moved along the displacement such that normal . displacement is the change of the
/// gap, whatever is nearest at the two ends (the discrete gradient of Gonzalez).
/// @param scale  of the coordinates: changes below their rounding are left out [m]
Vector<3> along_motion(const Vector<3>& normal, const Vector<3>& path, double change, double scale);

/// Gap from the differences of two points.
HardGap gap_of_points(const Vector<3>& d0, const Vector<3>& d1);
/// Signed gap from a face; gap from its edges and corners only where the point is in front of the
/// face.
/// @param y  at the start and at the end
/// @returns false: the point is behind an edge or corner
bool gap_of_facet(const HardFoot& foot, const HardCorners& start, const HardCorners& end,
                  const std::array<Vector<3>, 2>& y, HardGap& gap);

/// The least distances of a point to facets, by the vertices and edges that these share.
class LeastDistances {
 public:
  void add(const std::array<std::int32_t, 3>& facet, int count, double distance);
  /// Whether no facet with the edge or corner of the foot is nearer than this, but for rounding.
  bool is_least(const std::array<std::int32_t, 3>& facet, const HardFoot& foot,
                double distance) const;

 private:
  std::map<std::array<std::int32_t, 2>, double> least_;  // a vertex has its number twice
};

/// For each vertex 1 where it sticks out of the facets around it, or is on a free border. Only
/// those that are asked for are looked at.
std::vector<char> sticking_out(std::span<const std::array<std::int32_t, 3>> facets, int count,
                               std::span<const Vector<3>> vertices, std::vector<char> asked);

/// Vertices of the facets and edges that are in contact with a sphere already.
class FootVertices {
 public:
  void add(const std::array<std::int32_t, 3>& facet, const HardFoot& foot);
  /// Whether all vertices of this edge or corner belong to one that is known.
  bool has(const std::array<std::int32_t, 3>& facet, const HardFoot& foot) const;
  void clear() { known_.clear(); }

 private:
  std::vector<std::vector<std::int32_t>> known_;
};

}  // namespace gabion::mpm
