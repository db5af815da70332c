// SPDX-License-Identifier: BSD-3-Clause
// Bands of shear: what the tangents of the laws say of their direction, and how a layer with one
// unloads.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "tests/support/verification_row.hpp"
#include "tests/unit/materials/random_state.hpp"

namespace gabion::testing {
namespace {

using test::Measure;
using test::verify;

// Stresses are so small that strains do not turn them.
constexpr double E = 1e10, nu = 0.3, c_0 = 1e3;  // [Pa], -, [Pa]
constexpr double lambda = E * nu / ((1 + nu) * (1 - 2 * nu)), mu = E / (2 * (1 + nu));

/// Soil whose cohesion changes by `slope` with the strain kappa, at constant phi and psi.
SofteningSoil<2> soil(double phi, double psi, double slope) {
  const Strength start{c_0, std::sin(phi * degree), std::sin(psi * degree)};
  Strength end = start;  // a strain of 1 away, so that the curve is straight where it is used
  end.cohesion += slope;
  SofteningParameters parameters{
      .lambda = lambda,
      .mu = mu,
      .curve = StrengthCurve(ExponentialCurve{.peak = start, .residual = end, .scale = 1})};
  parameters.frictional = phi > 0;
  parameters.by_slip = false;
  return SofteningSoil<2>(parameters);
}

/// Moduli of soil that yields in compression along y, in an increment without strain.
Tangent<2> moduli(const SofteningSoil<2>& law) {
  PointContext context{.dt = 1};
  Matrix<2> H = Matrix<2>::Zero();
  H(1, 1) = -9 * c_0 / E;
  H(0, 0) = 2.7 * c_0 / E;
  StressUpdate<2> out;
  MaterialState<2> state;
  Tangent<2> A;
  for (const double share : {1., 1e-7}) {  // to yielding, and on by almost nothing
    if (!law.update(context, share * H, state, out, &A)) throw Error("no stress");
    EXPECT_EQ(out.region, YieldRegion::shear);
    state = out.state;
    context.internal = out.internal;
  }
  EXPECT_GT(out.tau[0], out.tau[2]);  // the stress out of plane is between the others
  EXPECT_GT(out.tau[2], out.tau[1]);
  return A;
}

/// det(n A n) by M^2, n across a band at an angle to the x axis [rad].
double acoustic(const Tangent<2>& A, double angle) {
  const Vector<2> n(-std::sin(angle), std::cos(angle));
  Matrix<2> Q = Matrix<2>::Zero();
  for (int i = 0; i < 2; ++i)
    for (int J = 0; J < 2; ++J)
      for (int k = 0; k < 2; ++k)
        for (int L = 0; L < 2; ++L) Q(i, k) += n[J] * A(i * 2 + J, k * 2 + L) * n[L];
  return Q.determinant() / ((lambda + 2 * mu) * (lambda + 2 * mu));
}

/// The angle in (0, 90 deg) with the smallest determinant, by golden sections about the best of
/// many.
double weakest_angle(const Tangent<2>& A) {
  double best = 0;
  const double step = 0.5 * degree;
  for (double angle = step; angle < 90 * degree; angle += step) {
    if (acoustic(A, angle) < acoustic(A, best)) best = angle;
  }
  double low = best - step, high = best + step;
  for (int k = 0; k < 60; ++k) {
    const double a = low + 0.382 * (high - low), b = low + 0.618 * (high - low);
    (acoustic(A, a) < acoustic(A, b) ? high : low) = acoustic(A, a) < acoustic(A, b) ? b : a;
  }
  return 0.5 * (low + high);
}

/// Bands form first at H_cr = E (sin phi - sin psi)^2 / (16 (1 - nu^2)), with
/// f = (t1 - t3) / 2 + (t1 + t3) sin(phi) / 2 - c cos(phi), at the angle
/// 90 deg - acos((sin phi + sin psi) / 2) / 2 to the axis of the least compression.
TEST(VA5_Bands, form_at_the_modulus_and_the_angle_of_the_bifurcation) {
  for (const auto& [phi, psi] : {std::pair{35., 8.}, {30., 0.}, {35., 35.}}) {
    const double s = std::sin(phi * degree), t = std::sin(psi * degree);
    // kappa by the multiplier of the flow rule
    const double strain = std::sqrt(1. / 3 + t * t / 9);
    const auto with = [&](double modulus) {
      return moduli(soil(phi, psi, modulus / (std::cos(phi * degree) * strain)));
    };
    double low = -0.02 * E, high = 0.05 * E;
    for (int k = 0; k < 50; ++k) {
      const double middle = 0.5 * (low + high);
      const auto A = with(middle);
      (acoustic(A, weakest_angle(A)) > 0 ? high : low) = middle;
    }
    const std::string what = fmt::format("Mohr-Coulomb, phi {}, psi {}: ", phi, psi);
    verify({.id = "VA5",
            .what = what + "hardening modulus over E at which bands form",
            .exact = (s - t) * (s - t) / (16 * (1 - nu * nu)),
            .computed = high / E,
            .measure = Measure::absolute_error,
            .bound = 1e-5});
    verify({.id = "VA5",
            .what = what + "angle of a band to the axis of the least compression",
            .exact = 90 - std::acos(0.5 * (s + t)) / (2 * degree),
            .computed = weakest_angle(with(high)) / degree,
            .measure = Measure::absolute_error,
            .bound = 0.05,
            .unit = "deg"});
  }
}

/// A layer of the height L with a band of the width w that loses h_s by its plastic shear strain
/// unloads with d tau / dU = 1 / (L / G - w / h_s), and snaps back if h_s > G w / L.
TEST(VA4_LayerWithABand, unloads_by_its_height_and_the_width_of_the_band) {
  const double L = 1;
  for (const double w : {0.05, 0.2}) {
    for (const double share : {0.5, 1.5}) {  // of the loss at which the layer snaps back
      const double h_s = share * mu * w / L;
      const auto law = soil(0, 0, -std::numbers::sqrt3 * h_s);
      PointContext context{.dt = 1};
      Matrix<2> H = Matrix<2>::Zero();
      MaterialState<2> state;
      StressUpdate<2> out;
      double strain = 0, U[2], tau[2];
      const double steps[2] = {1.1 * c_0 / mu, 0.1 * c_0 / mu};
      for (int k = 0; k < 2; ++k) {
        H(0, 1) = steps[k];
        ASSERT_TRUE(law.update(context, H, state, out, nullptr));
        ASSERT_TRUE(out.plastic());
        state = out.state;
        context.internal = out.internal;
        strain += H(0, 1);
        tau[k] = out.tau[3];
        U[k] = (L - w) * tau[k] / mu + w * strain;
      }
      verify({.id = "VA4",
              .what = fmt::format("layer of {} m with a band of {} m, loss of strength {} of that "
                                  "at which it snaps back: d tau / dU over G",
                                  L, w, share),
              .exact = 1 / (L - w * mu / h_s),
              .computed = (tau[1] - tau[0]) / (U[1] - U[0]) / mu,
              .bound = 1e-5});
    }
  }
}

}  // namespace
}  // namespace gabion::testing
