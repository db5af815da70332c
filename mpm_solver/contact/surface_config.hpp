// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/mechanics/mesh/seen_facets.hpp"
#include "common/settings/scene.hpp"
#include "mpm_solver/contact/contact_settings.hpp"

namespace gabion::mpm {

/// Most segments of a polyline, and most boundary points of a surface.
inline constexpr int max_surface_points = 1000000;

KeyTable surface_keys();

/// Read "surface" of an interface or a rigid wall: a polyline in pieces, triangles of a file,
/// or groups of a mesh.
/// @throws ConfigError  too few or equal corners, too many pieces, unknown group, what
///                      read_triangles refuses
template <int dim>
ContactSurface<dim> read_surface(const Scene& scene, ConfigReader in);

/// Refuse more boundary points than `max_surface_points` at the key "points_per_facet".
template <int dim>
void check_point_count(const ConfigReader& in, const ContactSurface<dim>& surface,
                       int points_per_facet);

/// Refuse a surface with a facet that was seen before, at the key "surface"; note its facets.
template <int dim>
void require_new_facets(const ConfigReader& in, const ContactSurface<dim>& surface,
                        SeenFacets<dim>& seen);

}  // namespace gabion::mpm
