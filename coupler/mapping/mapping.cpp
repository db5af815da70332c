// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/mapping/mapping.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>

namespace gabion {

namespace {

std::string point_text(const Eigen::Vector3d& x, int dim) {
  return dim == 2 ? fmt::format("({}, {})", x(0), x(1))
                  : fmt::format("({}, {}, {})", x(0), x(1), x(2));
}

/// Each soil facet must look the same way as the structure's facet under its centroid.
void check_normals(const Surface& structure, const Surface& soil, const InterfaceMesh& mesh) {
  for (std::int64_t f = 0; f < soil.num_facets(); ++f) {
    const Eigen::Vector3d normal = soil.normal(f);
    const SurfacePoint image = structure.nearest_on_facets(soil.centroid(f), normal);
    const Eigen::Vector3d other = structure.normal(image.facet);
    require<ConfigError>(
        normal.dot(other) > 0,
        fmt::format("interface \"{}\": facet {} of the soil's side at {} has normal {}, the "
                    "structure's facet {} there has {}; allowed: normals that agree, both point "
                    "out of the structure",
                    mesh.name, f, point_text(soil.centroid(f), mesh.dim),
                    point_text(normal, mesh.dim), image.facet, point_text(other, mesh.dim)));
  }
}

}  // namespace

MappingSettings read_mapping_settings(ConfigReader in) {
  MappingSettings settings;
  settings.method =
      in.choice_or("method", {"nearest_projection", "nearest_neighbor"}, settings.method);
  settings.tolerance = in.number("tolerance", positive());
  in.finish();
  return settings;
}

Mapping::Mapping(const InterfaceMesh& structure, const InterfaceMesh& soil,
                 const MappingSettings& settings)
    : dim_(structure.dim) {
  require<ConfigError>(structure.dim == soil.dim,
                       fmt::format("interface \"{}\": the structure's side has dimension {}, the "
                                   "soil's {}; allowed: equal",
                                   structure.name, structure.dim, soil.dim));
  const Surface from(structure);
  const Surface to(soil);
  const bool project = settings.method == "nearest_projection";
  require<ConfigError>(!project || from.has_facets(),
                       fmt::format("interface \"{}\": the structure's side has no facets, which "
                                   "nearest_projection needs; allowed: nearest_neighbor",
                                   structure.name));
  for (std::int64_t v = 0; v < soil.num_vertices(); ++v) {
    const Eigen::Vector3d x = to.vertex(v);
    rows_.push_back(project ? from.nearest_on_facets(x) : from.nearest_vertex(x));
    const double distance = rows_.back().distance;
    farthest_ = std::max(farthest_, distance);
    require<ConfigError>(
        distance <= settings.tolerance,
        fmt::format("interface \"{}\": soil vertex {} at {} is {} m away from the structure's "
                    "surface, allowed: {} m (coupling/mapping/tolerance)",
                    soil.name, v, point_text(x, dim_), distance, settings.tolerance));
  }
  if (from.has_facets() && to.has_facets()) check_normals(from, to, soil);
}

void Mapping::to_soil(std::span<const double> structure, std::span<double> soil) const {
  assert(soil.size() == rows_.size() * dim_);
  for (std::size_t v = 0; v < rows_.size(); ++v) {
    for (int i = 0; i < dim_; ++i) {
      double sum = 0;
      for (int a = 0; a < rows_[v].count; ++a) {
        sum += rows_[v].weights[a] * structure[rows_[v].vertices[a] * dim_ + i];
      }
      soil[v * dim_ + i] = sum;
    }
  }
}

void Mapping::add_to_structure(std::span<const double> soil, std::span<double> structure) const {
  assert(soil.size() == rows_.size() * dim_);
  for (std::size_t v = 0; v < rows_.size(); ++v) {
    for (int a = 0; a < rows_[v].count; ++a) {
      for (int i = 0; i < dim_; ++i) {
        structure[rows_[v].vertices[a] * dim_ + i] += rows_[v].weights[a] * soil[v * dim_ + i];
      }
    }
  }
}

}  // namespace gabion
