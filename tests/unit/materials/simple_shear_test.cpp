// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "tests/unit/materials/random_state.hpp"

namespace gabion::testing {
namespace {

/// Shear a point in plane strain, no strain along the shear plane, normal stress held at
/// -sigma_n; returns the final tau_xy / sigma_n.
double strength_in_simple_shear(const auto& law, double sigma_n) {
  const auto& p = law.parameters();
  constexpr int steps = 200, yy = 3;
  const double dgamma = 0.2 * sigma_n / p.mu;
  MaterialState<2> state;
  state.e = std::expm1(-2 * sigma_n / (3 * p.lambda + 2 * p.mu)) * Symmetric<2>{1, 1, 1, 0};
  StressUpdate<2> out;
  for (int step = 0; step < steps; ++step) {
    Matrix<2> H = Matrix<2>::Zero();
    H(0, 1) = dgamma;
    Tangent<2> A;
    for (int iteration = 0; iteration < 20; ++iteration) {
      if (!law.update(H, state, out, &A)) throw Error("inverted");
      const double residual = out.P(1, 1) + sigma_n;
      if (std::abs(residual) < 1e-12 * sigma_n) break;
      H(1, 1) -= residual / A(yy, yy);
    }
    EXPECT_NEAR(out.P(1, 1), -sigma_n, 1e-9 * sigma_n) << "step " << step;
    state = out.state;
  }
  return std::abs(out.tau[3] / out.tau[1]);
}

/// sin phi cos psi / (1 - sin phi sin psi), Davis (1968): below tan phi when psi < phi.
TEST(SimpleShear, StrengthIsTheDavisRatio) {
  struct Row {
    double phi, psi, ratio;
  };
  const double E = 1e9, nu = 0.3, sigma_n = 1e3;
  const double lambda = E * nu / ((1 + nu) * (1 - 2 * nu)), mu = E / (2 * (1 + nu));
  for (const auto& [phi, psi, ratio] :
       {Row{19.8, 0, 0.33874}, Row{30, 0, 0.50000}, Row{30, 10, 0.53922}, Row{30, 30, 0.57735}}) {
    const double sin_phi = std::sin(phi * degree), sin_psi = std::sin(psi * degree);
    const double davis = sin_phi * std::cos(psi * degree) / (1 - sin_phi * sin_psi);
    const MohrCoulomb<2> law{lambda, mu, phi * degree, psi * degree, 0};
    const double found = strength_in_simple_shear(law, sigma_n);
    EXPECT_NEAR(found, davis, 1e-5) << phi << ", " << psi;
    EXPECT_NEAR(found, ratio, 1e-5) << phi << ", " << psi;
  }
}

}  // namespace
}  // namespace gabion::testing
