// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/mechanics/mesh/boundary.hpp"
#include "mpm_solver/contact/contact_settings.hpp"

namespace gabion::mpm {

/// A place on a facet.
struct FacetPoint {
  std::array<double, 4> phi{};  ///< weights of the facet's vertices
  double share = 0;             ///< of the facet's area
};

/// n midpoints on a segment; on a triangle or quadrilateral the rule with n points.
std::vector<FacetPoint> facet_points(CellType type, int n);

/// A surface at the end of the current step.
template <int dim>
class MovingSurface {
 public:
  explicit MovingSurface(ContactSurface<dim> surface);

  /// @param displacement  from the reference, num_vertices x dim [m]
  void set_displacement(std::span<const double> displacement);

  std::size_t num_vertices() const { return vertices_.size(); }
  std::size_t num_facets() const { return surface_.facets.size() / vertices_per_facet_; }
  const std::vector<Vector<dim>>& positions() const { return vertices_; }
  int vertices_per_facet() const { return vertices_per_facet_; }
  std::int32_t vertex(std::int32_t facet, int k) const {
    return surface_.facets[facet * vertices_per_facet_ + k];
  }
  /// Areas and normals of the facets.
  std::vector<FacetGeometry<dim>> geometry() const {
    return facet_geometry<dim>(vertices_, surface_.facet_type, surface_.facets);
  }
  Vector<dim> position(std::int32_t facet, const std::array<double, 4>& phi) const;
  /// Normal and tangents of a facet; in 3D the first tangent follows its first edge.
  /// @param n  its normal
  Matrix<dim> frame(std::int32_t facet, const Vector<dim>& n) const;

 private:
  ContactSurface<dim> surface_;  // reference
  int vertices_per_facet_;
  std::vector<Vector<dim>> vertices_;
};

}  // namespace gabion::mpm
