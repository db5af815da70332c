// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/run/solver.hpp"
#include "coupler/mapping/closest_point.hpp"

namespace gabion {

/// A place on a surface: vertices and their weights, which sum to 1.
struct SurfacePoint {
  std::array<std::int64_t, 4> vertices{};
  std::array<double, 4> weights{};
  int count = 0;
  double distance = 0;      ///< [m] from the point that was asked for
  std::int64_t facet = -1;  ///< -1: a bare vertex
};

/// Searches on an interface mesh in its reference configuration.
class Surface {
 public:
  /// @throws ConfigError  dimension, facet shape, vertex numbers or facets without extent
  explicit Surface(const InterfaceMesh& mesh);
  ~Surface();
  Surface(const Surface&) = delete;
  Surface& operator=(const Surface&) = delete;
  Surface(Surface&&) = delete;
  Surface& operator=(Surface&&) = delete;

  const std::string& name() const { return mesh_.name; }  ///< name of the interface
  std::int64_t num_vertices() const { return mesh_.num_vertices(); }
  bool has_facets() const { return !mesh_.facets.empty(); }
  std::int64_t num_facets() const;
  Eigen::Vector3d vertex(std::int64_t v) const;
  Eigen::Vector3d centroid(std::int64_t facet) const;
  Eigen::Vector3d normal(std::int64_t facet) const;  ///< unit length, out of the structure

  SurfacePoint nearest_vertex(const Eigen::Vector3d& p) const;
  /// The `count` vertices nearest to p (all, if there are fewer), ascending.
  std::vector<std::int64_t> nearest_vertices(const Eigen::Vector3d& p, int count) const;
  /// Vertices closer to p than `radius` [m], ascending.
  std::vector<std::int64_t> vertices_within(const Eigen::Vector3d& p, double radius) const;
  /// Closest place, exact over all facets. @param preferred  among facets equally far away, the one
  /// whose normal agrees best with this direction; zero = any
  SurfacePoint nearest_on_facets(const Eigen::Vector3d& p,
                                 const Eigen::Vector3d& preferred = Eigen::Vector3d::Zero()) const;

 private:
  struct Trees;
  SurfacePoint closest_on_facet(const Eigen::Vector3d& p, std::int64_t facet) const;

  InterfaceMesh mesh_;
  double facet_radius_ = 0;  // [m] largest distance of a facet's vertex from its centroid
  std::unique_ptr<Trees> trees_;
};

}  // namespace gabion
