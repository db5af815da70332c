// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/SparseCore>
#include <span>
#include <string>
#include <vector>

#include "common/run/solver.hpp"
#include "common/settings/config_reader.hpp"
#include "coupler/mapping/radial_basis.hpp"
#include "coupler/mapping/surface.hpp"

namespace gabion {

/// The "coupling/mapping" object of coupler.json.
struct MappingSettings {
  std::string method = "nearest_projection";  ///< | nearest_neighbor | radial_basis
  double tolerance = 0;  ///< [m] > 0, largest distance of a soil vertex from the structure
  RadialBasisSettings radial_basis = {};
  bool deformed = false;  ///< set up again in deformed positions; nearest_projection only
  double moved = 1e-3;    ///< [of the extent] >= 0, after a vertex has moved by more than this
};
KeyTable mapping_keys();
MappingSettings read_mapping_settings(ConfigReader in);

/// Measures of how well the two surfaces of an interface fit.
struct MappingReport {
  std::int64_t soil_vertices = 0;  ///< all of them have an image, else the mapping is refused
  std::int64_t structure_vertices = 0;
  std::int64_t unused_vertices = 0;  ///< of the structure: no soil vertex takes more than round-off
  double farthest = 0;               ///< [m] of a soil vertex from its place on the structure
  double largest_shift = 0;   ///< [m] |H X_structure - X_soil|, the error for a rotation by 1
  double largest_weight = 0;  ///< |H_ij|, 1 unless extrapolated
};

/// Linear map H between the two copies of one interface. Displacements go from structure to soil by
/// H (constants are kept; linear fields too, unless by nearest_neighbor), forces come back by H^T:
/// resultant force and work are equal on both sides whatever H is, the moment too where linear
/// fields are kept and the soil's vertices lie on the structure's surface.
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

  /// Both sides have the same vertices in the same order: values are copied.
  bool is_identity() const { return identity_; }
  const MappingReport& report() const { return report_; }
  std::int64_t num_weights() const { return H_.nonZeros(); }

 private:
  std::vector<SurfacePoint> find_images(const Surface& from, const Surface& to,
                                        const MappingSettings& settings);
  void measure(const Surface& from, const Surface& to);

  int dim_;
  Eigen::SparseMatrix<double, Eigen::RowMajor> H_;  // soil's x structure's vertices
  bool identity_ = false;
  MappingReport report_;
};

}  // namespace gabion
