// SPDX-License-Identifier: BSD-3-Clause
// Water without time to drain, against closed forms of small strains.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/saturated_soil.hpp"

namespace gabion::test {
namespace {

/// The soil of saturated_elastic() with water of this bulk modulus.
struct Soil {
  static constexpr double E = 20e6, nu = 0.3;
  static constexpr double G = E / (2 * (1 + nu)), K = E / (3 * (1 - 2 * nu)), M = K + 4 * G / 3;
  double Q;  ///< K_w / n

  explicit Soil(double K_w) : Q(K_w / porosity) {}
  double wave_speed() const { return std::sqrt((M + Q) / saturated_density); }
  /// Pressure over the stress of a loaded side where the soil cannot expand sideways.
  double confined() const { return Q / (M + Q); }
  /// This ratio for a strip in plane strain whose other sides are free (Skempton 1954).
  double strip() const {
    const double B = Q / (K + Q), K_u = K + Q, nu_u = (3 * K_u - 2 * G) / (2 * (3 * K_u + G));
    return B * (1 + nu_u) / 3;
  }
};

double pressure_of(const mpm::MaterialPoints<2>& points, std::int32_t p, double K_w) {
  mpm::PoreWater water;
  water.porosity = porosity;
  water.bulk_modulus = K_w;
  water.cavitation = 1e12;
  return water.at(points.water[p], points.J[p]).p;
}

/// A square that a smooth plate presses by 1e-7 of its height.
TEST(VW7_Skempton, pressure_of_a_load) {
  for (const bool strip : {false, true}) {
    for (const double K_w : {2.2e9, 0.22e9}) {
      Json json = {
          {"dimension", 2},
          {"grid", box({0, 0}, {strip ? 1.5 : 1, 1}, {strip ? 6 : 4, 4}, "quad4")},
          {"basis", "gimp"},
          {"analysis", "quasi_static"},
          {"gravity", {0, 0}},
          {"walls", {wall("bottom", "slip"), wall("left", "slip"), wall("top", "slip")}},
          {"bodies", {body("soil", box({0, 0}, {1, 1}, {4, 4}, "quad4"), 4, saturated_elastic())}},
          {"locking", {{"method", "fbar"}}},
          {"newton", exact_newton}};
      if (!strip) json["walls"].push_back(wall("right", "slip"));
      json["walls"][2]["motion"] = {{"table", {{0, 0, 0}, {1, 0, -1e-7}}}};
      json["bodies"][0]["water"] = {
          {"porosity", porosity}, {"bulk_modulus", K_w}, {"cavitation_pressure", 1e5}};
      const auto solver = mpm_solver<2>(json);
      run_steps(*solver, 1, 1);
      const auto& points = solver->points();
      double pressure = 0, stress = 0;
      for (std::int32_t p = 0; p < points.size(); ++p) {
        pressure += pressure_of(points, p, K_w);
        stress -= points.tau[p][1] / points.J[p];
      }
      const Soil soil(K_w);
      verify({.id = "VW7",
              .what = fmt::format("P7, {}, K_w {:g} GPa: pore pressure over the load",
                                  strip ? "strip with free sides" : "confined", K_w / 1e9),
              .exact = strip ? soil.strip() : soil.confined(),
              .computed = pressure / stress,
              .bound = 1e-5});
    }
  }
}

/// A bar of 100 cells, one end of which moves from the start with v: stress rho c_u v behind a
/// front at c_u t.
struct Bar {
  double K_w;
  bool drains;  ///< with a permeability so small that no cell drains
  bool in_explicit_steps;
};

void expect_wave(const Bar& bar) {
  const Soil soil(bar.K_w);
  const double v = 0.01, h = 0.01, c = soil.wave_speed(), dt = 0.5 * h / c;
  Json json = {
      {"dimension", 2},
      {"grid", box({0, 0}, {1 + 2 * h, h}, {102, 1}, "quad4")},
      {"basis", "gimp"},
      {"gravity", {0, 0}},
      {"walls", {wall("left", "slip"), wall("bottom", "slip"), wall("top", "slip")}},
      {"bodies", {body("bar", box({0, 0}, {1, h}, {100, 1}, "quad4"), 4, saturated_elastic())}},
      {"locking", {{"method", "fbar"}}}};
  json["walls"][0]["motion"] = {{"velocity", {v, 0}}};
  json["bodies"][0]["water"] = {{"porosity", porosity}, {"bulk_modulus", bar.K_w}};
  if (bar.drains) {
    json["bodies"][0]["water"]["permeability"] = 1e-14;
  } else {
    json["bodies"][0]["water"]["cavitation_pressure"] = 1e6;
  }
  if (bar.in_explicit_steps) json["time_integration"] = {{"scheme", "explicit"}};
  const auto solver = mpm_solver<2>(json);
  const int steps = 160;  // the front is at 0.8
  double impulse = 0;
  for (int n = 1; n <= steps; ++n) {
    run_steps(*solver, dt, 1, n);
    if (n > steps / 4) impulse += std::abs(probe(*solver, "wall.left.fx")) * dt / h;
  }
  const auto& points = solver->points();
  double behind = 0, momentum = 0;
  int count = 0;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    momentum += points.m[p] * points.v[p][0];
    if (points.x[p][0] < 0.1 || points.x[p][0] > 0.6) continue;
    behind += pressure_of(points, p, bar.K_w);
    ++count;
  }
  const double stress = saturated_density * c * v;
  const std::string what = fmt::format("P8, K_w {:g} GPa, {}: ", bar.K_w / 1e9,
                                       !bar.drains             ? "undrained, explicit"
                                       : bar.in_explicit_steps ? "k 1e-14 m/s, fractional step"
                                                               : "k 1e-14 m/s, implicit");
  verify({.id = "VW8",
          .what = what + "stress on the moving end",
          .exact = stress,
          .computed = impulse / (0.75 * steps * dt),
          .bound = 1e-3,
          .unit = "Pa"});
  verify({.id = "VW8",
          .what = what + "pore pressure behind the front over the stress",
          .exact = soil.confined(),
          .computed = behind / count / stress,
          .bound = 0.005});
  verify({.id = "VW8",
          .what = what + "displacement of the front from the momentum",
          .exact = c * steps * dt,
          .computed = momentum / (saturated_density * h * v),
          // The fractional step is half a substep, 0.25 cells, ahead after a sudden push.
          .bound = bar.drains && bar.in_explicit_steps ? 0.004 : 1e-4,
          .unit = "m"});
}

TEST(VW8_UndrainedWave, along_a_bar) {
  for (const double K_w : {2.2e9, 0.22e9}) {
    expect_wave({K_w, false, true});
    expect_wave({K_w, true, false});
  }
  expect_wave({0.22e9, true, true});
}

}  // namespace
}  // namespace gabion::test
