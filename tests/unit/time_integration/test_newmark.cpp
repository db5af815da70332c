// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "common/mechanics/time_integration/newmark.hpp"
#include "tests/support/convergence_rate.hpp"

namespace gabion {
namespace {

/// u'' + omega^2 u = 0
struct Oscillator {
  double omega = 1, u = 1, v = 0, a = -1;

  double energy() const { return 0.5 * v * v + 0.5 * omega * omega * u * u; }

  void step(const NewmarkBossak& scheme, double dt) {
    const double w2 = omega * omega;
    // r(du) = -inertia - w2 (u + du) is linear: one Newton step from du = 0.
    const double r = -scheme.inertia(scheme.acceleration(0, v, a, dt), a) - w2 * u;
    const double du = r / (scheme.inertia_slope(dt) + w2);
    const double a_new = scheme.acceleration(du, v, a, dt);
    v = scheme.velocity(a_new, v, a, dt);
    u += du;
    a = a_new;
  }
};

double error_at_end(const NewmarkBossak& scheme, int steps) {
  Oscillator o;
  const double end = 5;
  for (int n = 0; n < steps; ++n) o.step(scheme, end / steps);
  return std::hypot(o.u - std::cos(end), o.v + std::sin(end));
}

TEST(NewmarkBossak, SecondOrder) {
  for (const double alpha : {0.0, -0.1, -0.3, -1.0 / 3}) {
    std::vector<double> sizes, errors;
    for (const int steps : {100, 200, 400, 800}) {
      sizes.push_back(5.0 / steps);
      errors.push_back(error_at_end(NewmarkBossak::bossak(alpha), steps));
    }
    EXPECT_GT(test::lowest_rate(sizes, errors), 1.9) << alpha;
    EXPECT_LT(test::last_rate(sizes, errors), 2.1) << alpha;
  }
}

TEST(NewmarkBossak, TrapezoidKeepsTheEnergy) {
  for (const double dt : {0.01, 0.3, 20.0}) {
    Oscillator o;
    const double start = o.energy();
    for (int n = 0; n < 1000; ++n) o.step(NewmarkBossak{}, dt);
    EXPECT_NEAR(o.energy() / start, 1, 1e-11) << dt;
  }
}

TEST(NewmarkBossak, ZeroAlphaIsTheTrapezoid) {
  const auto scheme = NewmarkBossak::bossak(0);
  EXPECT_EQ(scheme.beta, 0.25);
  EXPECT_EQ(scheme.gamma, 0.5);
}

// Amplitude per step for omega dt -> infinity.
TEST(NewmarkBossak, SpectralRadiusAtInfinity) {
  for (const double alpha : {-0.05, -0.1, -0.2, -0.3}) {
    Oscillator o{.omega = 1e6, .u = 1e-6, .v = 0.3, .a = 0.7};
    const auto scheme = NewmarkBossak::bossak(alpha);
    for (int n = 0; n < 200; ++n) o.step(scheme, 1.0);
    const auto size = [&o] { return std::hypot(o.v, o.a); };
    const double before = size();
    const int steps = 20;
    for (int n = 0; n < steps; ++n) o.step(scheme, 1.0);
    // A double eigenvalue: growth n rho^n, so the mean over n steps is high by (1 + 20/200)^(1/20).
    EXPECT_NEAR(std::pow(size() / before, 1.0 / steps), (1 + alpha) / (1 - alpha), 0.01) << alpha;
  }
}

TEST(NewmarkBossak, AccelerationAndVelocityAreExactForConstantAcceleration) {
  const double v = 0.7, a = -1.3, dt = 0.2;
  for (const double alpha : {0.0, -0.2}) {
    const auto scheme = NewmarkBossak::bossak(alpha);
    const double du = v * dt + 0.5 * a * dt * dt;
    EXPECT_NEAR(scheme.acceleration(du, v, a, dt), a, 1e-14);
    EXPECT_NEAR(scheme.velocity(a, v, a, dt), v + a * dt, 1e-15);
    EXPECT_NEAR(scheme.inertia(a, a), a, 1e-15);
    // The derivative of a linear function is its difference quotient.
    const auto inertia = [&](double x) {
      return scheme.inertia(scheme.acceleration(x, v, a, dt), a);
    };
    EXPECT_NEAR((inertia(du + 1) - inertia(du)) / scheme.inertia_slope(dt), 1, 1e-12);
  }
}

TEST(NewmarkBossak, Config) {
  const auto read = [](const Json& json) {
    return read_newmark_bossak(ConfigReader(json, "f.json"));
  };
  EXPECT_EQ(read(Json::object()).alpha_bossak, 0);
  EXPECT_EQ(read({{"scheme", "bossak"}}).alpha_bossak, -0.1);
  EXPECT_EQ(read({{"scheme", "bossak"}, {"alpha", -0.3}}).gamma, 0.8);
  EXPECT_THROW(read({{"scheme", "bossak"}, {"alpha", 0.1}}), ConfigError);
  EXPECT_THROW(read({{"scheme", "bossak"}, {"alpha", -0.34}}), ConfigError);
  EXPECT_THROW(read({{"scheme", "newmark"}, {"alpha", -0.1}}), ConfigError);
  EXPECT_THROW(read({{"scheme", "verlet"}}), ConfigError);
  EXPECT_THROW(NewmarkBossak::bossak(0.2), ConfigError);
  EXPECT_THROW(NewmarkBossak::bossak(-0.4), ConfigError);
}

}  // namespace
}  // namespace gabion
