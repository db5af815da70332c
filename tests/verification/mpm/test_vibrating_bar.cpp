// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/convergence_rate.hpp"
#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {
namespace {

constexpr double L = 25, E = 100, density = 1, v0 = 0.1;  // c = 10 m/s, first period 4 L / c = 10 s
constexpr int cells = 20;

/// Fixed at x = 0, free at x = L, moving in its first mode; smooth walls above and below.
Json bar(const Json& scheme = trapezoid) {
  const double h = L / cells;
  Json bodies = Json::array();
  for (int i = 0; i < cells; ++i) {
    bodies.push_back(body("cell" + std::to_string(i),
                          box({i * h, 0}, {(i + 1) * h, h}, {1, 1}, "quad4"), 4,
                          elastic_soil("linear_elastic", E, 0, density),
                          {v0 * std::sin(M_PI * (i + 0.5) / (2 * cells)), 0}));
  }
  return {{"dimension", 2},
          {"grid", box({0, 0}, {L + h, h}, {cells + 1, 1}, "quad4")},
          {"walls", {wall("left", "fixed"), wall("bottom", "slip"), wall("top", "slip")}},
          {"bodies", bodies},
          {"time_integration", scheme},
          {"newton", exact_newton},
          {"probes", {{{"name", "tip"}, {"point", {L, 0.2 * h}}}}}};
}

const Json generalized = {{"scheme", "generalized_alpha"}, {"rho_inf", 0.6}};

double tip_at(double time, int steps, const Json& scheme) {
  const auto solver = make_mpm(bar(scheme));
  run_steps(*solver, time / steps, steps);
  return probe(*solver, "tip.ux");
}

TEST(V7_VibratingBar, period_and_energy_of_the_first_mode) {
  const auto solver = make_mpm(bar());
  const double dt = 0.1, energy = probe(*solver, "kinetic_energy");
  double before = 0, first = 0, last = 0, amplitude = 0;
  int upward = 0;
  for (int n = 1; n <= 320; ++n) {
    run_steps(*solver, dt, 1, n);
    const double u = probe(*solver, "tip.ux");
    amplitude = std::max(amplitude, u);
    if (before < 0 && u >= 0) {
      last = (n - u / (u - before)) * dt;
      if (upward++ == 0) first = last;
    }
    before = u;
  }
  ASSERT_EQ(upward, 3);
  const double period = (last - first) / 2;
  const double loss =
      1 - (probe(*solver, "kinetic_energy") + probe(*solver, "elastic_energy")) / energy;
  verify({.id = "V7",
          .what = "period, fixed-free bar in its first mode, MPM 2D",
          .exact = 10,
          .computed = period,
          .bound = 2e-3,
          .unit = "s"});
  EXPECT_NEAR(amplitude, v0 * 10 / (2 * M_PI), 0.01 * amplitude);
  EXPECT_GT(loss, 0);
  verify({.id = "V7",
          .what = "energy loss in 3.2 periods, fixed-free bar, MPM 2D",
          .exact = 0,
          .computed = loss,
          .measure = Measure::absolute_error,
          .bound = 2e-3});
}

TEST(V7_VibratingBar, second_order_in_the_time_step) {
  const double end = 8, reference = tip_at(end, 1280, trapezoid);
  for (const Json& scheme : {trapezoid, generalized}) {
    std::vector<double> sizes, errors;
    for (const int steps : {20, 40, 80}) {
      sizes.push_back(end / steps);
      errors.push_back(std::abs(tip_at(end, steps, scheme) - reference));
    }
    verify({.id = "V7",
            .what = "order in dt, " +
                    std::string(scheme == trapezoid ? "trapezoidal rule" : "generalized-alpha") +
                    ", MPM 2D",
            .exact = 2,
            .computed = lowest_rate(sizes, errors),
            .measure = Measure::order,
            .bound = 1.9});
  }
}

}  // namespace
}  // namespace gabion::test
