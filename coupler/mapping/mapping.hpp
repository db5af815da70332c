// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "common/base/config_reader.hpp"
#include "common/base/solver.hpp"
#include "coupler/mapping/surface.hpp"

namespace gabion {

/// The "coupling/mapping" object of coupler.json.
struct MappingSettings {
  std::string method = "nearest_projection";  ///< nearest_projection | nearest_neighbor
  double tolerance = 0;  ///< [m] > 0, largest distance of a soil vertex from its image
};
MappingSettings read_mapping_settings(ConfigReader in);

/// Linear map H between the two copies of one interface. Displacements go from structure to soil by
/// H (constants are kept; linear fields too, with nearest_projection), forces come back by H^T:
/// resultant force and work are equal on both sides whatever H is, the moment too when the soil's
/// vertices lie on the structure's surface.
class Mapping {
 public:
  /// @throws ConfigError  dimensions differ; a soil vertex is farther away than the tolerance;
  ///                      facets of the two sides that face each other have opposite normals
  Mapping(const InterfaceMesh& structure, const InterfaceMesh& soil,
          const MappingSettings& settings);

  /// soil = H structure. @param structure, soil  num_vertices x dim, row-major
  void to_soil(std::span<const double> structure, std::span<double> soil) const;
  /// structure += H^T soil
  void add_to_structure(std::span<const double> soil, std::span<double> structure) const;

  double farthest() const { return farthest_; }  ///< [m] of a soil vertex from its image
  std::int64_t num_matched() const { return static_cast<std::int64_t>(rows_.size()); }

 private:
  int dim_;
  std::vector<SurfacePoint> rows_;  // of H, one a soil vertex
  double farthest_ = 0;
};

}  // namespace gabion
