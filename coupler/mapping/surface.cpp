// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/mapping/surface.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <limits>
#include <nanoflann.hpp>

#include "common/base/require.hpp"

namespace gabion {

using Vector3 = Eigen::Vector3d;

namespace {

void check_shape(const InterfaceMesh& mesh) {
  const auto where = fmt::format("interface \"{}\": ", mesh.name);
  require<ConfigError>(mesh.dim == 2 || mesh.dim == 3, "{}found dimension {}, allowed: 2, 3", where,
                       mesh.dim);
  require<ConfigError>(!mesh.coordinates.empty() && mesh.coordinates.size() % mesh.dim == 0,
                       "{}found {} coordinates, allowed: a multiple of {}, not 0", where,
                       mesh.coordinates.size(), mesh.dim);
  const int n = mesh.vertices_per_facet;
  const bool fits = n == 0 || (mesh.dim == 2 ? n == 2 : n == 3 || n == 4);
  require<ConfigError>(fits, "{}found facets of {} vertices in {}D, allowed: {}", where, n,
                       mesh.dim, mesh.dim == 2 ? "0, 2" : "0, 3, 4");
  require<ConfigError>(n == 0 ? mesh.facets.empty() : mesh.facets.size() % n == 0,
                       "{}found {} vertex numbers for facets of {}", where, mesh.facets.size(), n);
  for (const std::int64_t v : mesh.facets) {
    require<ConfigError>(v >= 0 && v < mesh.num_vertices(),
                         "{}a facet names vertex {}, allowed: 0 to {}", where, v,
                         mesh.num_vertices() - 1);
  }
}

}  // namespace

struct Surface::Trees {
  /// Adaptor of points for nanoflann.
  struct Cloud {
    std::vector<Vector3> points;
    std::size_t kdtree_get_point_count() const { return points.size(); }
    double kdtree_get_pt(std::size_t i, std::size_t axis) const {
      return points[i](static_cast<Eigen::Index>(axis));
    }
    template <class Box>
    bool kdtree_get_bbox(Box&) const {
      return false;  // nanoflann computes it
    }
  };

  /// Collects the points that a search finds within a distance, with the functions that every
  /// version of nanoflann needs.
  struct Near {
    using DistanceType = double;
    using IndexType = std::size_t;

    double squared_distance;
    std::vector<std::size_t> indices{};

    std::size_t size() const { return indices.size(); }
    bool empty() const { return indices.empty(); }
    bool full() const { return true; }
    double worstDist() const { return squared_distance; }
    bool addPoint(double squared, std::size_t index) {
      if (squared < squared_distance) indices.push_back(index);
      return true;
    }
    void sort() { std::sort(indices.begin(), indices.end()); }
  };

  using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Cloud>,
                                                   Cloud, 3, std::size_t>;

  Cloud vertices;
  Cloud centroids;
  std::unique_ptr<Tree> vertex_tree;
  std::unique_ptr<Tree> centroid_tree;

  /// Indices of the points that are nearer to p, ascending: they do not depend on the tree.
  static std::vector<std::size_t> within(const Tree& tree, const Vector3& p, double distance) {
    Near near{.squared_distance = distance * distance};
    tree.radiusSearchCustomCallback(p.data(), near);
    near.sort();
    return std::move(near.indices);
  }
};

Surface::Surface(const InterfaceMesh& mesh) : mesh_(mesh), trees_(std::make_unique<Trees>()) {
  check_shape(mesh_);
  for (std::int64_t v = 0; v < mesh_.num_vertices(); ++v) {
    trees_->vertices.points.push_back(vertex(v));
    require<ConfigError>(vertex(v).allFinite(), "interface \"{}\": vertex {} is not finite",
                         mesh_.name, v);
  }
  trees_->vertex_tree = std::make_unique<Trees::Tree>(3, trees_->vertices);
  trees_->vertex_tree->buildIndex();
  if (!has_facets()) return;
  for (std::int64_t f = 0; f < num_facets(); ++f) {
    trees_->centroids.points.push_back(centroid(f));
    for (int a = 0; a < mesh_.vertices_per_facet; ++a) {
      const Vector3 corner = vertex(mesh_.facets[f * mesh_.vertices_per_facet + a]);
      facet_radius_ = std::max(facet_radius_, (corner - centroid(f)).norm());
    }
    require<ConfigError>(normal(f).allFinite(), "interface \"{}\": facet {} has no extent",
                         mesh_.name, f);
  }
  trees_->centroid_tree = std::make_unique<Trees::Tree>(3, trees_->centroids);
  trees_->centroid_tree->buildIndex();
}

Surface::~Surface() = default;

std::int64_t Surface::num_facets() const {
  return has_facets() ? static_cast<std::int64_t>(mesh_.facets.size()) / mesh_.vertices_per_facet
                      : 0;
}

Vector3 Surface::vertex(std::int64_t v) const {
  Vector3 x = Vector3::Zero();
  for (int i = 0; i < mesh_.dim; ++i) x(i) = mesh_.coordinates[v * mesh_.dim + i];
  return x;
}

Vector3 Surface::centroid(std::int64_t facet) const {
  Vector3 sum = Vector3::Zero();
  const int n = mesh_.vertices_per_facet;
  for (int a = 0; a < n; ++a) sum += vertex(mesh_.facets[facet * n + a]);
  return sum / n;
}

Vector3 Surface::normal(std::int64_t facet) const {
  const std::int64_t* v = &mesh_.facets[facet * mesh_.vertices_per_facet];
  if (mesh_.dim == 2) {
    const Vector3 along = vertex(v[1]) - vertex(v[0]);
    return Vector3(along(1), -along(0), 0) / along.norm();
  }
  // The normal follows from the diagonals of a quad, from two edges of a triangle.
  const bool quad = mesh_.vertices_per_facet == 4;
  const Vector3 first = quad ? vertex(v[2]) - vertex(v[0]) : vertex(v[1]) - vertex(v[0]);
  const Vector3 second = quad ? vertex(v[3]) - vertex(v[1]) : vertex(v[2]) - vertex(v[0]);
  const Vector3 normal = first.cross(second);
  return normal / normal.norm();
}

SurfacePoint Surface::nearest_vertex(const Vector3& p) const {
  std::size_t index = 0;
  double squared = 0;
  trees_->vertex_tree->knnSearch(p.data(), 1, &index, &squared);
  SurfacePoint result;
  result.vertices[0] = static_cast<std::int64_t>(index);
  result.weights[0] = 1;
  result.count = 1;
  result.distance = (vertex(result.vertices[0]) - p).norm();
  return result;
}

std::vector<std::int64_t> Surface::nearest_vertices(const Vector3& p, int count) const {
  std::vector<std::size_t> found(static_cast<std::size_t>(count));
  std::vector<double> squared(found.size());
  found.resize(
      trees_->vertex_tree->knnSearch(p.data(), found.size(), found.data(), squared.data()));
  std::sort(found.begin(), found.end());
  return {found.begin(), found.end()};
}

std::vector<std::int64_t> Surface::vertices_within(const Vector3& p, double radius) const {
  const auto found = Trees::within(*trees_->vertex_tree, p, radius);
  return {found.begin(), found.end()};
}

SurfacePoint Surface::closest_on_facet(const Vector3& p, std::int64_t facet) const {
  SurfacePoint result;
  result.count = mesh_.vertices_per_facet;
  result.facet = facet;
  std::array<Vector3, 4> x;
  for (int a = 0; a < result.count; ++a) {
    result.vertices[a] = mesh_.facets[facet * result.count + a];
    x[a] = vertex(result.vertices[a]);
  }
  const ClosestPoint found = result.count == 2   ? closest_on_segment(p, x[0], x[1])
                             : result.count == 3 ? closest_on_triangle(p, {x[0], x[1], x[2]})
                                                 : closest_on_quad(p, x);
  result.weights = found.weights;
  result.distance = found.distance;
  return result;
}

SurfacePoint Surface::nearest_on_facets(const Vector3& p, const Vector3& preferred) const {
  // Centroids are points of the surface, so the nearest one bounds the distance; the nearest facet
  // has its centroid within that bound plus the size of a facet.
  std::size_t index = 0;
  double squared = 0;
  trees_->centroid_tree->knnSearch(p.data(), 1, &index, &squared);
  const double reach = (std::sqrt(squared) + facet_radius_) * (1 + 1e-9);
  const double same = 1e-9 * facet_radius_;
  SurfacePoint best;
  best.distance = std::numeric_limits<double>::infinity();
  for (const std::size_t facet : Trees::within(*trees_->centroid_tree, p, reach)) {
    const SurfacePoint found = closest_on_facet(p, static_cast<std::int64_t>(facet));
    const bool tie = best.facet >= 0 && std::abs(found.distance - best.distance) <= same;
    const bool better = tie ? preferred.dot(normal(found.facet)) > preferred.dot(normal(best.facet))
                            : found.distance < best.distance;
    if (better) best = found;
  }
  return best;
}

}  // namespace gabion
