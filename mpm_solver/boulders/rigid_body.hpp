// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "common/mechanics/tensor.hpp"

namespace gabion::mpm {

/// Mass of a rigid body. In 2D all is per metre of thickness and the motion stays in the plane: the
/// inertia is then I times the identity, I that about the normal of the plane.
struct BodyMass {
  double mass = 0;                            ///< [kg]
  Vector<3> centre = Vector<3>::Zero();       ///< of mass, in the coordinates of the shape [m]
  Matrix<3> inertia = Matrix<3>::Identity();  ///< about the centre, in axes of the body [kg m^2]
};

/// Place and motion of a rigid body, in 2D with zeros out of the plane.
struct BodyState {
  Vector<3> x = Vector<3>::Zero();                        ///< of the centre of mass [m]
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();  ///< turns axes of the body to space
  Vector<3> v = Vector<3>::Zero();                        ///< [m/s]
  Vector<3> W = Vector<3>::Zero();                        ///< in axes of the body [rad/s]

  Vector<3> spin() const { return q * W; }                      ///< in space [rad/s]
  Vector<3> at(const Vector<3>& X) const { return x + q * X; }  ///< place of X of the body
};

/// Motion of a rigid body over a time: a point of it with the mean arm r_m = (r_0 + r_1) / 2 goes
/// by exactly shift + turn x r_m.
struct BodyMove {
  Vector<3> shift = Vector<3>::Zero();  ///< [m]
  Vector<3> turn = Vector<3>::Zero();   ///< dt R_0 (W_0 + W_1) / 2
};

/// Force and moment about the centre of mass, in space, constant in a step.
struct BodyLoad {
  Vector<3> force = Vector<3>::Zero();   ///< [N]
  Vector<3> moment = Vector<3>::Zero();  ///< [N m]
};

/// A step of the implicit midpoint rule, with Cayley's map for the rotation: kinetic energy changes
/// by exactly the work of the load on BodyMove, the angular momentum by exactly its impulse.
/// @throws ConvergenceError  the spin in a step is too large to find its end
BodyState advance(const BodyMass& mass, const BodyState& start, const BodyLoad& load, double dt);

BodyMove move_of(const BodyState& start, const BodyState& end, double dt);

double kinetic_energy(const BodyMass& mass, const BodyState& state);
/// Angular momentum about the centre of mass, in axes of space [kg m^2/s].
Vector<3> angular_momentum(const BodyMass& mass, const BodyState& state);

}  // namespace gabion::mpm
