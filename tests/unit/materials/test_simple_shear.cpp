// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "tests/unit/materials/random_state.hpp"

namespace gabion::testing::test_simple_shear {
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
TEST(SimpleShear, strength_is_the_davis_ratio) {
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
    const DruckerPrager<2> cone({.lambda = lambda,
                                 .mu = mu,
                                 .friction_angle = phi * degree,
                                 .dilation_angle = psi * degree});
    EXPECT_NEAR(strength_in_simple_shear(cone, sigma_n), davis, 1e-5) << phi << ", " << psi;
  }
}

/// Squeeze a point in plane strain, lateral stress held at -sigma_3; returns sigma_1 / sigma_3.
double strength_in_biaxial_compression(const auto& law, double sigma_3) {
  constexpr int steps = 200, xx = 0;
  const auto& p = law.parameters();
  const double strain = 0.2 * sigma_3 / p.mu;
  MaterialState<2> state;
  state.e = std::expm1(-2 * sigma_3 / (3 * p.lambda + 2 * p.mu)) * Symmetric<2>{1, 1, 1, 0};
  StressUpdate<2> out;
  for (int step = 0; step < steps; ++step) {
    Matrix<2> H = Matrix<2>::Zero();
    H(1, 1) = -strain;
    Tangent<2> A;
    for (int iteration = 0; iteration < 20; ++iteration) {
      if (!law.update(H, state, out, &A)) throw Error("inverted");
      const double residual = out.P(0, 0) + sigma_3;
      if (std::abs(residual) < 1e-12 * sigma_3) break;
      H(0, 0) -= residual / A(xx, xx);
    }
    EXPECT_NEAR(out.P(0, 0), -sigma_3, 1e-9 * sigma_3) << "step " << step;
    state = out.state;
  }
  return out.tau[1] / out.tau[0];
}

/// s1 / s3 = Kp = (1 + sin phi) / (1 - sin phi) for Mohr-Coulomb and, whatever psi, for the cone
/// that is matched to it in plane strain. Any cone has the Kp of the friction angle sin phi = eta w
/// / (1 - eta eta_bar / 3), w^2 = 1 - eta_bar^2 / 3, at which it flows.
TEST(Biaxial, strength_is_kp) {
  struct Row {
    double phi, psi;
  };
  const double lambda = 5.8e8, mu = 3.8e8, sigma_3 = 1e3;
  for (const auto& [phi, psi] : {Row{19.8, 0}, Row{30, 0}, Row{30, 10}, Row{30, 30}}) {
    const double Kp = (1 + std::sin(phi * degree)) / (1 - std::sin(phi * degree));
    const MohrCoulomb<2> pyramid{lambda, mu, phi * degree, psi * degree, 0};
    EXPECT_NEAR(strength_in_biaxial_compression(pyramid, sigma_3), Kp, 1e-5 * Kp) << phi << psi;
    DruckerPragerParameters cone{
        .lambda = lambda, .mu = mu, .friction_angle = phi * degree, .dilation_angle = psi * degree};
    EXPECT_NEAR(strength_in_biaxial_compression(DruckerPrager<2>(cone), sigma_3), Kp, 1e-5 * Kp)
        << phi << ", " << psi;
    for (const ConeMatch match : {ConeMatch::compression, ConeMatch::extension}) {
      cone.match = match;
      const auto [l, m, eta, eta_bar, strength] = cone_constants(cone);
      const double sine = eta * std::sqrt(1 - eta_bar * eta_bar / 3) / (1 - eta * eta_bar / 3);
      const double found = strength_in_biaxial_compression(DruckerPrager<2>(cone), sigma_3);
      EXPECT_NEAR(found, (1 + sine) / (1 - sine), 1e-5 * found) << phi << ", " << psi;
    }
  }
}

}  // namespace
}  // namespace gabion::testing::test_simple_shear
