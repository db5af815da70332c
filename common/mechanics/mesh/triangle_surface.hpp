// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/mechanics/tensor.hpp"

namespace gabion {

/// A surface of triangles in space; normals by the right-hand rule.
struct TriangleSurface {
  std::vector<Vector<3>> vertices;                     ///< [m]
  std::vector<std::array<std::int32_t, 3>> triangles;  ///< vertices of each
};

/// Source of the normals of a file.
enum class TriangleNormals {
  file,  ///< the order of the vertices; normals that an STL file writes down are passed over
  up     ///< along z: triangles that look down are turned, as terrain asks for
};

/// Vertices nearer than this share of the longest side of the surface's box are one.
inline constexpr double merge_share = 1e-6;

/// Surface of a .stl (text or bytes) or .ply (text or little-endian bytes) file: vertices merged
/// by `merge_share`, those that no triangle uses dropped.
/// @throws ConfigError  "<path>: line or byte n: ..."; a triangle without area; neighbours that
///                      look to different sides; with `up` a vertical triangle
TriangleSurface read_triangles(const std::string& path, TriangleNormals normals);

/// Contents of the files, checked for their format only.
TriangleSurface read_stl(const std::string& path);
TriangleSurface read_ply(const std::string& path);

}  // namespace gabion
