// SPDX-License-Identifier: BSD-3-Clause
// Paths of stress of Cam-Clay. Stresses of undrained paths are Kirchhoff's, which are Cauchy's too,
// as the volume stays.
#include <fmt/format.h>

#include "tests/support/verification_row.hpp"
#include "tests/unit/materials/cam_clay_element.hpp"

namespace gabion::testing {
namespace {

using test::Measure;
using test::verify;

constexpr double M = 1.2, lambda = 0.09, kappa = 0.009;

/// The largest q of an undrained path, p = p_0 (R M^2 / (M^2 + eta^2))^L with
/// L = 1 - kappa / lambda, which for R above 2 lies before the critical state.
double largest_undrained(double ocr) {
  const double L = 1 - kappa / lambda, eta = M / std::sqrt(2 * L - 1);
  return eta * p_0 * std::pow(ocr * M * M / (M * M + eta * eta), L);
}

/// Undrained shear from p_0 to the critical state: p_f = p_0 (R / 2)^(1 - kappa / lambda),
/// c_u = M p_f / 2.
TEST(VA7_CamClayUndrained, ends_at_the_critical_state) {
  for (const double ocr : {1., 2., 4.}) {
    CamClayElement soil(ocr);
    double largest = 0;
    for (int n = 0; n < 6000; ++n) {
      soil.strain({5e-5, 5e-5, -1e-4});
      largest = std::max(largest, soil.q());
    }
    const double p_f = p_0 * std::pow(ocr / 2, 1 - kappa / lambda);
    const std::string what = fmt::format("Cam-Clay, undrained, overconsolidation ratio {}, ", ocr);
    verify({.id = "VA7",
            .what = what + "pressure at the critical state",
            .exact = p_f,
            .computed = soil.P(),
            .bound = 1e-6,
            .unit = "Pa"});
    verify({.id = "VA7",
            .what = what + "undrained strength",
            .exact = M * p_f / 2,
            .computed = soil.q() / 2,
            .bound = 1e-6,
            .unit = "Pa"});
    if (ocr < 4) continue;
    verify({.id = "VA7",
            .what = what + "largest q before it",
            .exact = largest_undrained(ocr),
            .computed = largest,
            .bound = 1e-5,
            .unit = "Pa"});
  }
}

/// p = p_0 (M^2 / (M^2 + eta^2))^(1 - kappa / lambda) at eta = q / p.
TEST(VA8_CamClayUndrainedPath, is_the_closed_one) {
  CamClayElement soil(1);
  double next = 0.2;
  for (int n = 0; n < 1000 && next < 1; ++n) {
    soil.strain({2e-5, 2e-5, -4e-5});
    const double eta = soil.q() / soil.P();
    if (eta < next) continue;
    next += 0.23;
    verify({.id = "VA8",
            .what = fmt::format("Cam-Clay, undrained, normally consolidated: pressure at q / p = "
                                "{:.6f}",
                                eta),
            .exact = p_0 * std::pow(M * M / (M * M + eta * eta), 1 - kappa / lambda),
            .computed = soil.P(),
            .bound = 1e-8,
            .unit = "Pa"});
  }
  EXPECT_GT(next, 1);
}

/// q at which drained compression of overconsolidated soil leaves the elastic range: on the ellipse
/// of the Kirchhoff stresses J p and J q, with q = 3 (p - p_0) and ln J = -kappa ln(J p / p_0).
double drained_yield(double ocr) {
  double low = p_0, high = ocr * p_0;
  for (int k = 0; k < 100; ++k) {
    const double p = 0.5 * (low + high), q = 3 * (p - p_0);
    const double J = std::exp(-kappa / (1 + kappa) * std::log(p / p_0));
    const double f = J * q * q / (M * M) + p * (J * p - ocr * p_0);
    (f > 0 ? high : low) = p;
  }
  return 3 * (low - p_0);
}

TEST(VA9_CamClayDrained, yields_on_its_ellipse) {
  CamClayElement soil(4);
  double largest = 0;
  for (int n = 0; n < 4000 && soil.q() >= largest; ++n) {
    largest = soil.q();
    soil.compress_drained(2e-5, p_0);
  }
  verify({.id = "VA9",
          .what = "Cam-Clay, drained, overconsolidation ratio 4, q where it yields",
          .exact = drained_yield(4),
          .computed = largest / soil.J,
          .bound = 1e-3,
          .unit = "Pa"});
}

/// q at axial Hencky strains, by integration of the rate equations extrapolated from 10000 and
/// 20000 explicit steps.
TEST(VA9_CamClayDrained, has_its_curve) {
  CamClayElement soil(1);
  int n = 0;
  for (const auto& [strain, q] : {std::pair{0.01, 34.2226e3},
                                  {0.02, 53.2754e3},
                                  {0.05, 91.1421e3},
                                  {0.1, 130.8562e3},
                                  {0.2, 172.2600e3}}) {
    for (; n < std::lround(strain / 2e-5); ++n) soil.compress_drained(2e-5, p_0);
    verify({.id = "VA9",
            .what = fmt::format("Cam-Clay, drained, normally consolidated: q at a strain of {}",
                                strain),
            .exact = q,
            .computed = soil.q() / soil.J,
            .bound = 1e-3,
            .unit = "Pa"});
  }
}

/// One-dimensional compression from an isotropic state: the slope d ln J / d ln sigma_v tends to
/// -lambda / (1 + lambda) as the ratio of the stresses settles. The constant shear modulus falls
/// behind the pressure, so that it drifts later. The other values are from 100000 explicit steps.
TEST(VA10_CamClayOedometer, follows_the_virgin_line) {
  CamClayElement soil(1);
  const double step = 2e-5;
  double before = 0, stress = 0, slope_at_5 = 0;
  for (int n = 1; n <= 5000; ++n) {
    soil.strain({0, 0, -step});
    before = stress;
    stress = -soil.out.tau[2] / soil.J;
    if (n == 2500) slope_at_5 = -step / std::log(stress / before);
  }
  const std::string what = "Cam-Clay, oedometer from 100 kPa, ";
  verify({.id = "VA10",
          .what = what + "d ln J / d ln sigma_v at ln J = -0.05",
          .exact = -lambda / (1 + lambda),
          .computed = slope_at_5,
          .bound = 2e-3});
  verify({.id = "VA10",
          .what = what + "vertical stress at ln J = -0.1",
          .exact = 387.2e3,
          .computed = stress,
          .bound = 1e-3,
          .unit = "Pa"});
  verify({.id = "VA10",
          .what = what + "ratio of the stresses at ln J = -0.1",
          .exact = 0.6748,
          .computed = soil.out.tau[0] / soil.out.tau[2],
          .bound = 1e-3});
}

/// Drained with the Cauchy stress p_0 at the side: q = 3 M p_0 / (3 - M), and
/// ln J (1 + lambda) = -kappa ln(p_f / p_0) - (lambda - kappa) ln(2 p_f / (R p_0)).
TEST(VA9_CamClayDrained, ends_at_the_critical_state) {
  const double q = 3 * M * p_0 / (3 - M), p_f = p_0 + q / 3;
  for (const double ocr : {1., 1.5, 4.}) {
    CamClayElement soil(ocr);
    for (int n = 0; n < 2000; ++n) soil.compress_drained(1e-3, p_0);
    const std::string what = fmt::format("Cam-Clay, drained, overconsolidation ratio {}, ", ocr);
    verify({.id = "VA9",
            .what = what + "q at the critical state",
            .exact = q,
            .computed = soil.q() / soil.J,
            .bound = 2e-4,
            .unit = "Pa"});
    verify({.id = "VA9",
            .what = what + "ln J at the critical state",
            .exact = -(kappa * std::log(p_f / p_0) +
                       (lambda - kappa) * std::log(2 * p_f / (ocr * p_0))) /
                     (1 + lambda),
            .computed = std::log(soil.J),
            .measure = Measure::absolute_error,
            .bound = 1e-4});
  }
}

}  // namespace
}  // namespace gabion::testing
