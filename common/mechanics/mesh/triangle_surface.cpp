// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/mesh/triangle_surface.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <utility>

#include "common/base/require.hpp"

namespace gabion {

namespace {

using Triangle = std::array<std::int32_t, 3>;

/// Finds the vertex that stands for a place: cubes of the edge 2 tolerance, of which at most eight
/// hold what is near.
class Merger {
 public:
  explicit Merger(double tolerance) : tolerance_(tolerance) {}

  std::int32_t vertex_at(const Vector<3>& x, std::vector<Vector<3>>& vertices) {
    for (int corner = 0; corner < 8; ++corner) {
      const Vector<3> shift(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
      const auto found = cubes_.equal_range(cube_of(x + tolerance_ * shift));
      for (auto entry = found.first; entry != found.second; ++entry) {
        if ((vertices[entry->second] - x).norm() <= tolerance_) return entry->second;
      }
    }
    vertices.push_back(x);
    const auto vertex = static_cast<std::int32_t>(vertices.size()) - 1;
    cubes_.emplace(cube_of(x), vertex);
    return vertex;
  }

 private:
  using Cube = std::array<std::int64_t, 3>;
  struct CubeHash {
    std::size_t operator()(const Cube& cube) const {
      std::size_t hash = 0;
      for (const std::int64_t k : cube) {
        hash = (hash ^ static_cast<std::size_t>(k)) * std::size_t{0x9E3779B97F4A7C15};
      }
      return hash ^ (hash >> 29);
    }
  };
  Cube cube_of(const Vector<3>& x) const {
    Cube cube;
    for (int d = 0; d < 3; ++d) {
      cube[d] = static_cast<std::int64_t>(std::floor(x[d] / (2 * tolerance_)));
    }
    return cube;
  }

  double tolerance_;
  std::unordered_multimap<Cube, std::int32_t, CubeHash> cubes_;
};

double longest_side(const TriangleSurface& surface) {
  Vector<3> low = Vector<3>::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const Vector<3>& x : surface.vertices) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  return (high - low).maxCoeff();
}

TriangleSurface merged(const TriangleSurface& raw, const std::string& path) {
  TriangleSurface surface;
  const double side = longest_side(raw);
  require<ConfigError>(side > 0, "{}: found all vertices in one place", path);
  double farthest = 0;
  for (const Vector<3>& x : raw.vertices) farthest = std::max(farthest, x.cwiseAbs().maxCoeff());
  // Places are counted in steps of the tolerance.
  require<ConfigError>(
      side < std::numeric_limits<double>::max() && farthest / (merge_share * side) < 1e18,
      "{}: found coordinates up to {} of a surface {} m long, which their digits do "
      "not resolve",
      path, farthest, side);
  Merger merger(merge_share * side);
  for (const Triangle& triangle : raw.triangles) {
    Triangle& added = surface.triangles.emplace_back();
    for (int k = 0; k < 3; ++k) {
      added[k] = merger.vertex_at(raw.vertices[triangle[k]], surface.vertices);
    }
  }
  return surface;
}

Vector<3> area_normal(const TriangleSurface& surface, const Triangle& t) {
  const auto& x = surface.vertices;
  return (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]);
}

std::string place(const Vector<3>& x) {
  return fmt::format("({:.9g}, {:.9g}, {:.9g})", x[0], x[1], x[2]);
}

void check_areas(const TriangleSurface& surface, const std::string& path) {
  const double smallest = std::pow(merge_share * longest_side(surface), 2);
  for (std::size_t k = 0; k < surface.triangles.size(); ++k) {
    const Triangle& t = surface.triangles[k];
    const bool apart = t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
    require<ConfigError>(apart && area_normal(surface, t).norm() > smallest, [&] {
      return fmt::format(
          "{}: found triangle {} (from 0) at {} without area, allowed: corners that differ by more "
          "than {} of the surface's size",
          path, k, place(surface.vertices[t[0]]), merge_share);
    });
  }
}

void turn_up(TriangleSurface& surface, const std::string& path) {
  for (std::size_t k = 0; k < surface.triangles.size(); ++k) {
    Triangle& t = surface.triangles[k];
    const Vector<3> normal = area_normal(surface, t);
    require<ConfigError>(std::abs(normal[2]) > 1e-9 * normal.norm(), [&] {
      return fmt::format(
          "{}: found triangle {} (from 0) at {} vertical, allowed with \"normals\": \"up\": "
          "triangles that look up or down",
          path, k, place(surface.vertices[t[0]]));
    });
    if (normal[2] < 0) std::swap(t[1], t[2]);
  }
}

// Neighbours that look to one side run along their edge in opposite senses.
void check_sides(const TriangleSurface& surface, const std::string& path) {
  std::unordered_map<std::uint64_t, std::size_t> owner;
  for (std::size_t k = 0; k < surface.triangles.size(); ++k) {
    const Triangle& t = surface.triangles[k];
    for (int e = 0; e < 3; ++e) {
      const std::int32_t from = t[e], to = t[(e + 1) % 3];
      const auto edge = (static_cast<std::uint64_t>(from) << 32) | static_cast<std::uint32_t>(to);
      const auto [entry, is_new] = owner.try_emplace(edge, k);
      require<ConfigError>(is_new, [&] {
        return fmt::format(
            "{}: triangles {} and {} (from 0) at {} look to different sides, or lie on each other; "
            "allowed: neighbours with normals to one side of the surface",
            path, entry->second, k, place(surface.vertices[from]));
      });
    }
  }
}

// Triangles that lie on each other in opposite senses enclose nothing: soil would be in contact
// with both.
void check_doubles(const TriangleSurface& surface, const std::string& path) {
  std::vector<std::pair<Triangle, std::size_t>> sorted;
  for (const Triangle& triangle : surface.triangles) {
    sorted.emplace_back(triangle, sorted.size());
    std::sort(sorted.back().first.begin(), sorted.back().first.end());
  }
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t k = 1; k < sorted.size(); ++k) {
    require<ConfigError>(sorted[k].first != sorted[k - 1].first, [&] {
      return fmt::format(
          "{}: triangles {} and {} (from 0) at {} lie on each other, allowed: each once", path,
          sorted[k - 1].second, sorted[k].second, place(surface.vertices[sorted[k].first[0]]));
    });
  }
}

}  // namespace

TriangleSurface read_triangles(const std::string& path, TriangleNormals normals) {
  const bool stl = path.ends_with(".stl") || path.ends_with(".STL");
  const bool ply = path.ends_with(".ply") || path.ends_with(".PLY");
  require<ConfigError>(stl || ply, "{}: allowed: a file whose name ends with .stl or .ply", path);
  TriangleSurface surface = stl ? read_stl(path) : read_ply(path);
  require<ConfigError>(!surface.triangles.empty(), "{}: found no triangle", path);
  surface = merged(surface, path);
  check_areas(surface, path);
  if (normals == TriangleNormals::up) turn_up(surface, path);
  check_sides(surface, path);
  check_doubles(surface, path);
  return surface;
}

}  // namespace gabion
