// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "mpm_solver/boulders/rigid_body.hpp"
#include "mpm_solver/contact/contact_settings.hpp"

namespace gabion::mpm {

/// A rigid body at rest at the origin: its mass, and its surface of facets whose normals point out.
template <int dim>
struct BoulderShape {
  BodyMass mass;
  ContactSurface<dim> surface;  ///< about the centre of mass, in axes of the body
  double radius = 0;            ///< of the sphere around the centre of mass that holds it [m]
  double sphere = 0;            ///< of a sphere or disc: its radius; others: 0 [m]
  Vector<dim> axes = Vector<dim>::Zero();  ///< of an ellipsoid: semi-axes; others: 0 [m]
  double thickness = 0;                    ///< smallest extent along an axis of the body [m]
};

/// Facets of a shape are about this many along its radius.
inline constexpr int facets_along_radius = 4;

/// A disc or sphere; its facets hold its area or volume.
template <int dim>
BoulderShape<dim> sphere_shape(double radius, double density);
/// A rectangle or box about the origin. @param size  of its sides [m]
template <int dim>
BoulderShape<dim> box_shape(const Vector<dim>& size, double density);
/// An ellipse or ellipsoid about the origin; its facets hold its area or volume.
/// @param axes  halves of its lengths [m]
template <int dim>
BoulderShape<dim> ellipsoid_shape(const Vector<dim>& axes, double density);

/// A body by its surface, moved to its centre of mass: facets of more than about a quarter of its
/// radius are divided evenly.
/// @throws ConfigError  the surface is open, turned inward or, in 2D, crosses itself: where; or its
///                      inertia is not positive
template <int dim>
BoulderShape<dim> surface_shape(ContactSurface<dim> surface, double density);

/// Mass of the body that a closed surface of segments or triangles encloses [kg].
template <int dim>
BodyMass mass_within(const ContactSurface<dim>& surface, double density);

}  // namespace gabion::mpm
