// SPDX-License-Identifier: BSD-3-Clause
// One element of Cam-Clay with the axes of its stretches fixed.
#pragma once

#include <gtest/gtest.h>

#include <cmath>

#include "common/mechanics/materials/cam_clay.hpp"

namespace gabion::testing {

inline constexpr double p_0 = 100e3;

/// lambda 0.09, kappa 0.009, M 1.2 by Kirchhoff stress; mu_0 5 MPa is a Poisson's ratio of 0.3043.
inline CamClayParameters clay(double attraction = 100) {
  return {.compression = 0.09,
          .swelling = 0.009,
          .critical_ratio = 1.2,
          .poisson_ratio = 0.3,
          .reference_pressure = p_0,
          .attraction = attraction};
}

/// A cube with the stretches of its axes as given, its pressure less the attraction.
struct CamClayElement {
  CamClay<3> law;
  InternalState internal;
  MaterialState<3> state;
  double J = 1;
  StressUpdate<3> out;

  /// @param ocr  P_c by the pressure
  explicit CamClayElement(double ocr, const CamClayParameters& parameters = clay(1e-6))
      : law(parameters), internal(ocr * p_0, 5e6) {}

  /// A step with these Hencky strains; it is kept if `accept`.
  void strain(const Eigen::Vector3d& eps, bool accept = true) {
    Matrix<3> H = Matrix<3>::Zero();
    for (int i = 0; i < 3; ++i) H(i, i) = std::expm1(eps[i]);
    ASSERT_TRUE(law.update({.internal = internal}, H, state, out, nullptr));
    if (!accept) return;
    state = out.state;
    internal = out.internal;
    J *= out.J;
  }
  double P() const { return -out.tau.head<3>().mean(); }
  /// Deviator stress of triaxial compression along the last axis.
  double q() const { return out.tau[0] - out.tau[2]; }
  /// A step of axial strain with the Cauchy stress sigma_0 in the other directions.
  void compress_drained(double step, double sigma_0) {
    double side = 0.4 * step, before = 0, excess_before = 0;
    for (int pass = 0; pass < 60; ++pass) {
      strain({side, side, -step}, false);
      const double excess = out.tau[0] / (J * out.J) + sigma_0;
      if (std::abs(excess) < 1e-11 * sigma_0) break;
      const double slope = pass == 0 ? 3e7 : (excess - excess_before) / (side - before);
      before = side;
      excess_before = excess;
      side -= excess / slope;
    }
    strain({side, side, -step});
    ASSERT_NEAR(-out.tau[0] / J, sigma_0, 1e-8 * sigma_0);
  }
};

}  // namespace gabion::testing
