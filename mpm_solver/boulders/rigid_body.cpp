// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/boulders/rigid_body.hpp"

#include <limits>

#include "common/base/error.hpp"

namespace gabion::mpm {

namespace {

constexpr int most_iterations = 30;
// Relative change of the angular velocity that is rounding.
constexpr double rounding = 1e-15;

Matrix<3> hat(const Vector<3>& a) {
  Matrix<3> result;
  result << 0, -a[2], a[1], a[2], 0, -a[0], -a[1], a[0], 0;
  return result;
}

// J (W_1 - W_0) + dt W_m x J W_m = dt (1 - hat(dt W_m) / 2) M, all in axes of the body at the
// start.
Vector<3> end_spin(const Matrix<3>& J, const Vector<3>& W0, const Vector<3>& M, double dt) {
  Vector<3> W1 = W0 + dt * J.inverse() * (M - W0.cross(J * W0));
  double last = std::numeric_limits<double>::infinity();
  for (int k = 0; k < most_iterations; ++k) {
    const Vector<3> Wm = 0.5 * (W0 + W1);
    const Vector<3> residual =
        J * (W1 - W0) + dt * Wm.cross(J * Wm) - dt * (M - 0.5 * dt * Wm.cross(M));
    const Matrix<3> slope = J + 0.5 * dt * (hat(Wm) * J - hat(J * Wm)) - 0.25 * dt * dt * hat(M);
    const Vector<3> change = slope.inverse() * residual;
    W1 -= change;
    const double size = change.norm();
    if (size <= rounding * (W0.norm() + W1.norm()) ||
        (k > 3 && size >= last && size < 1e-12 * W1.norm()))
      return W1;
    last = size;
  }
  throw ConvergenceError("a boulder turns too far in one step", "boulders");
}

}  // namespace

BodyState advance(const BodyMass& mass, const BodyState& start, const BodyLoad& load, double dt) {
  BodyState end;
  end.v = start.v + dt / mass.mass * load.force;
  end.x = start.x + 0.5 * dt * (start.v + end.v);
  end.W = end_spin(mass.inertia, start.W, start.q.conjugate() * load.moment, dt);
  const Vector<3> half = 0.25 * dt * (start.W + end.W);
  end.q = (start.q * Eigen::Quaterniond(1, half[0], half[1], half[2])).normalized();
  return end;
}

BodyMove move_of(const BodyState& start, const BodyState& end, double dt) {
  return {end.x - start.x, start.q * Vector<3>(0.5 * dt * (start.W + end.W))};
}

double kinetic_energy(const BodyMass& mass, const BodyState& state) {
  return 0.5 * (mass.mass * state.v.squaredNorm() + state.W.dot(mass.inertia * state.W));
}

Vector<3> angular_momentum(const BodyMass& mass, const BodyState& state) {
  return state.q * Vector<3>(mass.inertia * state.W);
}

}  // namespace gabion::mpm
