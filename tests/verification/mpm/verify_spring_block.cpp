// SPDX-License-Identifier: BSD-3-Clause
// A rigid block on a spring, pushed by an elastic slug, and by water that swings with it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"
#include "tests/verification/mpm/spring_block.hpp"

namespace gabion::test {
namespace {

/// Bar with smooth sides that flies with v0 at a block of the same section, 1 m^2.
constexpr double L = 1, E = 2e6, rho = 2000, v0 = 0.1;
const double c = std::sqrt(E / rho), Z = rho * c, T = 2 * L / c;
constexpr int cells = 100;
constexpr double slug_h = L / cells;

struct Peaks {
  double spring = 0;   ///< largest force of the spring over Z v0
  double impulse = 0;  ///< over 2 rho L v0
};

/// By characteristics: P = <G(t) - Z y'> in contact, G = Z v0 until T, then what comes back from
/// the free end, G(t) = (G - 2 P)(t - T). Without contact the face of the slug has the speed G / Z,
/// and P = 0 until the gap has closed.
Peaks exact(double m, double k, double end) {
  const int per_T = 20000, steps = static_cast<int>(std::lround(end / T * per_T));
  const double dt = T / per_T;
  std::vector<double> back;  // G - 2 P of each step
  double y = 0, v = 0, gap = 0;
  Peaks found;
  for (int i = 0; i < steps; ++i) {
    const double G = i < per_T ? Z * v0 : back[i - per_T];
    const auto pressure = [&](double speed) {
      return gap > 0 ? 0.0 : std::max(0.0, G - Z * speed);
    };
    const auto a = [&](double place, double speed) { return (pressure(speed) - k * place) / m; };
    const double y_mid = y + dt / 2 * v, v_mid = v + dt / 2 * a(y, v);
    const double P = pressure(v_mid);
    back.push_back(G - 2 * P);
    found.impulse += dt * P / (2 * rho * L * v0);
    v += dt * a(y_mid, v_mid);
    y += dt * v_mid;
    if (P == 0) gap = std::max(0.0, gap + dt * (v_mid - G / Z));
    found.spring = std::max(found.spring, k * y / (Z * v0));
  }
  return found;
}

Json slug() {
  const double low = -1.5 * slug_h;
  const int count = cells + 4;
  return {{"dimension", 2},
          {"grid", box({low, 0}, {low + count * slug_h, slug_h}, {count, 1}, "quad4")},
          {"basis", "linear"},
          {"walls", {wall("bottom", "slip"), wall("top", "slip")}},
          {"bodies",
           {body("slug", box({0, 0}, {L, slug_h}, {cells, 1}, "quad4"), 4,
                 elastic_soil("linear_elastic", E, 0, rho), {v0, 0})}},
          {"time_integration", {{"scheme", "bossak"}, {"alpha", -0.1}}},
          {"interfaces",
           {{{"name", "face"},
             {"surface", {{"polyline", {{L, slug_h}, {L, 0}}}, {"spacing", slug_h}}},
             {"mode", "slip"}}}}};
}

Peaks computed(double m, double k, double end) {
  const auto solver = make_mpm(slug());
  SpringBlock block{.m = m, .k = k};
  const double dt = 0.5 * slug_h / c;
  Peaks found;
  for (int n = 1; n * dt <= end; ++n) {
    const double P = step_with(*solver, block, "face", n, dt, 1 / slug_h);
    found.impulse += dt * P / (2 * rho * L * v0);
    found.spring = std::max(found.spring, k * block.y / (Z * v0));
  }
  return found;
}

TEST(VW23_SpringBlock, slug_strikes_it) {
  for (const auto& [m, k] : {std::pair{100.0, 1e6}, {100.0, 1e7}, {1000.0, 1e6}, {1000.0, 1e7}}) {
    const double end = 1.9 * T;
    const Peaks right = exact(m, k, end), found = computed(m, k, end);
    const std::string what = fmt::format("K3, slug on a block of {:g} kg and {:g} N/m: ", m, k);
    verify({.id = "VW23",
            .what = what + "largest force of the spring over Z v0",
            .exact = right.spring,
            .computed = found.spring,
            .bound = 0.02});
    verify({.id = "VW23",
            .what = what + "impulse in 1.9 T over 2 rho L v0",
            .exact = right.impulse,
            .computed = found.impulse,
            .bound = 0.02});
  }
}

/// Water of the depth H beside the block, a wall in the distance from it: it swings as if it had
/// m_a = (16 / pi^3) rho H^2 sum coth(l L / H) / (2 i - 1)^3 of the water besides,
/// l = (2 i - 1) pi / 2.
struct Basin {
  double depth = 0.5, length = 0.5;
  int cells = 10;  ///< over the depth
  double m = 50, k = 2e5;

  double added_mass() const {
    double sum = 0;
    for (int i = 1; i < 200; ++i) {
      const double l = (2 * i - 1) * std::numbers::pi / 2;
      sum += 1 / std::tanh(l * length / depth) / std::pow(2 * i - 1, 3);
    }
    return 16 / std::pow(std::numbers::pi, 3) * 1000 * depth * depth * sum;
  }
};

double frequency(const Basin& basin) {
  const double h = basin.depth / basin.cells, g = 9.81;
  const int along = static_cast<int>(std::lround(basin.length / h));
  const double wet = std::sqrt(basin.k / (basin.m + basin.added_mass())) / (2 * std::numbers::pi);
  Json water =
      body("water", box({0, 0}, {basin.length, basin.depth}, {along, basin.cells}, "quad4"), 4,
           {{"law", "newtonian"},
            {"density", 1000},
            {"sound_speed", 40 * wet * basin.depth},
            {"viscosity", 0}});
  water["initial_stress"] = {{"k0", 1}, {"surface", basin.depth}, {"max_displacement", 1e9}};
  const auto solver = make_mpm(
      {{"dimension", 2},
       {"grid", box({0, 0}, {basin.length + 2 * h, basin.depth + 2 * h},
                    {along + 2, basin.cells + 2}, "quad4")},
       {"walls", {wall("left", "slip"), wall("bottom", "slip")}},
       {"gravity", {0, -g}},
       {"time_integration", {{"scheme", "bossak"}}},
       {"bodies", {water}},
       {"interfaces",
        {{{"name", "face"},
          {"surface",
           {{"polyline", {{basin.length, basin.depth + h}, {basin.length, 0}}}, {"spacing", h}}},
          {"mode", "slip"}}}}});
  SpringBlock block{
      .m = basin.m, .k = basin.k, .P_0 = 500 * g * basin.depth * basin.depth, .v = 1e-3};
  const double dt = 1 / (60 * wet);
  std::vector<double> crossings;
  double before = 0;
  for (int n = 1; crossings.size() < 3 && n < 400; ++n) {
    step_with(*solver, block, "face", n, dt, 1);
    if (n > 1 && (block.y > 0) != (before > 0)) {
      crossings.push_back(dt * (n - block.y / (block.y - before)));
    }
    before = block.y;
  }
  return 1 / (crossings.at(2) - crossings.at(0));
}

TEST(VW24_AddedMass, water_swings_with_a_block) {
  for (const double m : {50.0, 200.0}) {
    const Basin basin{.m = m};
    verify({.id = "VW24",
            .what = fmt::format("K5, block of {:g} kg on a spring beside as long as deep a basin, "
                                "{:.0f} kg of added mass: frequency",
                                m, basin.added_mass()),
            .exact = std::sqrt(basin.k / (m + basin.added_mass())) / (2 * std::numbers::pi),
            .computed = frequency(basin),
            .bound = 0.01,
            .unit = "Hz"});
  }
}

}  // namespace
}  // namespace gabion::test
