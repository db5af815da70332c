// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <vector>

#include "common/mechanics/time_integration/newmark.hpp"
#include "tests/support/convergence_rate.hpp"
#include "tests/support/expect_error.hpp"

namespace gabion::test_newmark {
namespace {

/// u'' + omega^2 u = 0
struct Oscillator {
  double omega = 1, u = 1, v = 0, a = -1;

  double energy() const { return 0.5 * v * v + 0.5 * omega * omega * u * u; }

  void step(const NewmarkBossak& scheme, double dt) {
    const double w2 = omega * omega;
    // r(du) = -inertia - w2 (u + du) - memory w2 u is linear: one Newton step from du = 0.
    const double r =
        -scheme.inertia(scheme.acceleration(0, v, a, dt), a) - (1 + scheme.force_memory()) * w2 * u;
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

TEST(NewmarkBossak, second_order) {
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

TEST(NewmarkBossak, generalized_alpha_is_of_second_order) {
  for (const double rho : {0.0, 0.3, 0.5, 0.8, 1.0}) {
    std::vector<double> sizes, errors;
    for (const int steps : {100, 200, 400, 800}) {
      sizes.push_back(5.0 / steps);
      errors.push_back(error_at_end(NewmarkBossak::generalized_alpha(rho), steps));
    }
    EXPECT_GT(test::lowest_rate(sizes, errors), 1.9) << rho;
    EXPECT_LT(test::last_rate(sizes, errors), 2.1) << rho;
  }
}

TEST(NewmarkBossak, schemes_without_damping_keep_the_energy) {
  for (const auto& scheme : {NewmarkBossak{}, NewmarkBossak::generalized_alpha(1)}) {
    for (const double dt : {0.01, 0.3, 20.0}) {
      Oscillator o;
      const double start = o.energy();
      for (int n = 0; n < 1000; ++n) o.step(scheme, dt);
      EXPECT_NEAR(o.energy() / start, 1, 1e-11) << dt;
    }
  }
}

/// Largest eigenvalue of the matrix that takes (u, v dt, a dt^2) through a step.
double spectral_radius(const NewmarkBossak& scheme, double omega) {
  Eigen::Matrix3d amplification;
  for (int k = 0; k < 3; ++k) {
    Oscillator o{
        .omega = omega, .u = k == 0 ? 1.0 : 0, .v = k == 1 ? 1.0 : 0, .a = k == 2 ? 1.0 : 0};
    o.step(scheme, 1);
    amplification.col(k) = Eigen::Vector3d(o.u, o.v, o.a);
  }
  return amplification.eigenvalues().cwiseAbs().maxCoeff();
}

TEST(NewmarkBossak, spectral_radius_of_generalized_alpha) {
  for (const double rho : {0.0, 0.3, 0.5, 0.8, 0.95, 1.0}) {
    const auto scheme = NewmarkBossak::generalized_alpha(rho);
    // Three equal eigenvalues: a change of 1e-10 of the matrix moves them by its third root.
    EXPECT_NEAR(spectral_radius(scheme, 1e5), rho, 2e-3) << rho;
    for (double omega = 0.01; omega < 1e4; omega *= 1.5) {
      EXPECT_LE(spectral_radius(scheme, omega), 1 + 1e-6) << rho << " " << omega;
    }
  }
}

/// With rho_inf = 0.5 the low frequencies lose less than with the Bossak scheme of equal rho_inf.
TEST(NewmarkBossak, generalized_alpha_spares_low_frequencies) {
  const auto bossak = NewmarkBossak::bossak(-1.0 / 3);  // rho_inf = 1/2
  const auto scheme = NewmarkBossak::generalized_alpha(0.5);
  EXPECT_NEAR(spectral_radius(bossak, 1e5), 0.5, 2e-3);
  for (const double omega : {0.1, 0.3, 1.0}) {
    EXPECT_LT(1 - spectral_radius(scheme, omega), 0.7 * (1 - spectral_radius(bossak, omega)));
  }
}

TEST(NewmarkBossak, zero_alpha_is_the_trapezoid) {
  const auto scheme = NewmarkBossak::bossak(0);
  EXPECT_EQ(scheme.beta, 0.25);
  EXPECT_EQ(scheme.gamma, 0.5);
}

// Amplitude per step for omega dt -> infinity.
TEST(NewmarkBossak, spectral_radius_at_infinity) {
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

/// m = 1 with a spring and a force F that is constant over each step.
struct PushedMass {
  double u = 1, v = 0.3, a = 0, F = 0;  // a contains F

  void step(const NewmarkBossak& scheme, double dt, double w2, double F_new) {
    const double c = scheme.step_force_weight();
    const double r =
        c * F_new - (c - 1) * F - w2 * u - scheme.inertia(scheme.acceleration(0, v, a, dt), a);
    const double du = r / (scheme.inertia_slope(dt) + w2);
    const double a_new = scheme.acceleration(du, v, a, dt);
    u += du;
    v = scheme.velocity(a_new, v, a, dt) + dt * scheme.step_force_velocity() * (F_new - F);
    a = a_new - scheme.step_force_acceleration() * (F_new - F);
    F = F_new;
  }
};

double some_force(int n) {
  return std::sin(1.7 * n) + (n % 3 == 0 ? 2 : 0);
}

/// The defining equations, with the acceleration a_i of the spring kept apart from F.
TEST(NewmarkBossak, step_force_has_weights_of_constant_acceleration) {
  const double dt = 0.4, w2 = 3;
  for (const auto& scheme :
       {NewmarkBossak{}, NewmarkBossak::bossak(-0.2), NewmarkBossak::bossak(-1.0 / 3),
        NewmarkBossak::generalized_alpha(0), NewmarkBossak{.beta = 0.5, .gamma = 1}}) {
    PushedMass mass{.a = -w2};
    double u = mass.u, v = mass.v, a_i = -w2;
    for (int n = 0; n < 50; ++n) {
      const double F = some_force(n);
      mass.step(scheme, dt, w2, F);
      const double guess =
          u + dt * v + dt * dt * ((0.5 - scheme.beta) * a_i + 0.5 * F);  // + beta dt^2 a_i'
      const double a_new =
          -(w2 * guess + scheme.alpha_m * a_i) / (1 - scheme.alpha_m + w2 * scheme.beta * dt * dt);
      u = guess + scheme.beta * dt * dt * a_new;
      v += dt * ((1 - scheme.gamma) * a_i + scheme.gamma * a_new + F);
      a_i = a_new;
      EXPECT_NEAR(mass.u, u, 1e-12) << n;
      EXPECT_NEAR(mass.v, v, 1e-12) << n;
      EXPECT_NEAR(mass.a, a_i + F, 1e-12) << n;
    }
  }
}

TEST(NewmarkBossak, step_force_adds_its_work_and_its_impulse) {
  const NewmarkBossak trapezoid;
  for (const double w2 : {0.0, 0.1, 1e4}) {
    PushedMass mass{.a = -w2};
    for (int n = 0; n < 50; ++n) {
      const PushedMass before = mass;
      const auto energy = [w2](const PushedMass& m) { return 0.5 * (m.v * m.v + w2 * m.u * m.u); };
      mass.step(trapezoid, 0.4, w2, some_force(n));
      EXPECT_NEAR(energy(mass) - energy(before), mass.F * (mass.u - before.u),
                  1e-13 * (1 + energy(before)));
    }
  }
  for (const auto& scheme : {trapezoid, NewmarkBossak::bossak(-0.3)}) {
    PushedMass mass;
    for (int n = 0; n < 50; ++n) {
      const double v = mass.v;
      mass.step(scheme, 0.4, 0, some_force(n));
      EXPECT_NEAR(mass.v - v, 0.4 * mass.F, 1e-13);
    }
  }
}

TEST(NewmarkBossak, step_force_needs_no_correction_with_constant_acceleration) {
  const NewmarkBossak scheme{.beta = 0.5, .gamma = 1};
  EXPECT_EQ(scheme.step_force_weight(), 1);
  EXPECT_EQ(scheme.step_force_velocity(), 0);
  EXPECT_EQ(scheme.step_force_acceleration(), 0);
}

TEST(NewmarkBossak, acceleration_and_velocity_are_exact_for_constant_acceleration) {
  const double v = 0.7, a = -1.3, dt = 0.2;
  for (const auto& scheme :
       {NewmarkBossak{}, NewmarkBossak::bossak(-0.2), NewmarkBossak::generalized_alpha(0.6)}) {
    const double du = v * dt + 0.5 * a * dt * dt;
    EXPECT_NEAR(scheme.acceleration(du, v, a, dt), a, 1e-14);
    EXPECT_NEAR(scheme.velocity(a, v, a, dt), v + a * dt, 1e-15);
    EXPECT_NEAR(scheme.mean_acceleration(a, a), a, 1e-15);
    EXPECT_NEAR(scheme.mean_force(a, a), a, 1e-15);
    // A constant force balances it.
    EXPECT_NEAR(a + scheme.force_memory() * a, scheme.inertia(a, a), 1e-14);
    // The derivative of a linear function is its difference quotient.
    const auto inertia = [&](double x) {
      return scheme.inertia(scheme.acceleration(x, v, a, dt), a);
    };
    EXPECT_NEAR((inertia(du + 1) - inertia(du)) / scheme.inertia_slope(dt), 1, 1e-12);
  }
}

TEST(NewmarkBossak, config) {
  const auto read = [](const Json& json) {
    return read_newmark_bossak(ConfigReader(json, "f.json", newmark_keys("newmark")));
  };
  EXPECT_EQ(read(Json::object()).alpha_m, 0);
  EXPECT_EQ(read({{"scheme", "bossak"}}).alpha_m, -0.1);
  EXPECT_EQ(read({{"scheme", "bossak"}, {"alpha", -0.3}}).gamma, 0.8);
  EXPECT_EQ(read({{"scheme", "generalized_alpha"}, {"rho_inf", 1}}).alpha_f, 0.5);
  EXPECT_EQ(read({{"scheme", "generalized_alpha"}, {"rho_inf", 0}}).force_memory(), 0);
  EXPECT_NEAR(read({{"scheme", "generalized_alpha"}}).force_memory(), 0.8, 1e-15);
  const auto refuses = [&](const Json& json, const std::vector<std::string_view>& parts) {
    test::expect_error<ConfigError>([&] { read(json); }, parts);
  };
  refuses({{"scheme", "bossak"}, {"alpha", 0.1}}, {"/alpha: found 0.1", "[-1/3, 0]"});
  refuses({{"scheme", "bossak"}, {"alpha", -0.34}}, {"/alpha: found -0.34", "[-1/3, 0]"});
  refuses({{"scheme", "newmark"}, {"alpha", -0.1}}, {"/alpha", "unknown"});
  refuses({{"scheme", "verlet"}}, {"/scheme: found \"verlet\"", "bossak"});
  refuses({{"scheme", "generalized_alpha"}, {"rho_inf", 1.1}}, {"/rho_inf: found 1.1"});
  refuses({{"scheme", "generalized_alpha"}, {"alpha", -0.1}}, {"/alpha", "unknown"});
}

TEST(NewmarkBossak, parameters_out_of_range_are_refused) {
  using test::expect_error;
  expect_error<ConfigError>([] { NewmarkBossak::generalized_alpha(-0.1); },
                            {"rho_inf: found -0.1", "0 to 1"});
  expect_error<ConfigError>([] { NewmarkBossak::bossak(0.2); }, {"alpha: found 0.2", "-1/3 to 0"});
  expect_error<ConfigError>([] { NewmarkBossak::bossak(-0.4); },
                            {"alpha: found -0.4", "-1/3 to 0"});
}

}  // namespace
}  // namespace gabion::test_newmark
