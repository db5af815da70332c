// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "mpm_solver/boulders/ellipsoid.hpp"
#include "mpm_solver/boulders/hard_places.hpp"

namespace gabion::mpm {

/// An ellipsoid or what it meets, at the start, in the middle and at the end of a displacement.
template <class T>
struct OnPath {
  T start, half, end;
};

/// A contact point of an ellipsoid: on its surface, where that is nearest to the other one, or
/// deepest in it, in the middle of a displacement.
struct EllipsoidPlace {
  HardFoot foot = {};                       ///< on a facet
  double g0 = 0, g1 = 0;                    ///< gaps at the start and at the end [m]
  double extent = 0;                        ///< smallest of an ellipsoid, along the direction [m]
  Vector<3> direction = Vector<3>::Zero();  ///< of length 1, into the ellipsoid
  Vector<3> normal = Vector<3>::Zero();     ///< near to it, of the force
  Vector<3> x = Vector<3>::Zero();
};

/// The place of a facet, in the middle of the displacement, that is nearest to an ellipsoid, with
/// the gaps of the face, edge or corner that it is on.
/// @returns false: the ellipsoid is behind an edge or corner
bool place_on_facet(const OnPath<Ellipsoid>& own, const OnPath<HardCorners>& facet,
                    EllipsoidPlace& place);

EllipsoidPlace place_between(const OnPath<Ellipsoid>& own, const OnPath<Ellipsoid>& other);

/// Move normal and contact point, along its surface, such that the work of a force along the normal
/// is that of the gap (the discrete gradient of Gonzalez, in place and rotation): in a turn the
/// nearest place wanders.
/// @param path    of the contact point over the other one [m]
/// @param turn    of the ellipsoid over the other one [rad]
/// @param radius  of the ellipsoid [m]
void follow_gap(EllipsoidPlace& place, const Vector<3>& path, const Vector<3>& turn, double radius);

}  // namespace gabion::mpm
