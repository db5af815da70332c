// SPDX-License-Identifier: BSD-3-Clause
// Columns whose pore water drains at small strain, against the series of Terzaghi (1923).
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {
namespace {

constexpr double nu = 0.2, H = 1, water_density = 1000, K_w = 2.2e9, n0 = 0.4, g = 9.81;
constexpr double plate_g = 1e-3;  // gravity where a plate is the load [m/s^2]

/// Column of one cell across between smooth walls, with 1 / (M h) small beside 1 / K_w.
struct Drained {
  double E = 10e6, k = 9.81e-7;
  double load = 0;  ///< [Pa]; 0: under its own weight
  int cells = 20;

  double M() const { return E * (1 - nu) / ((1 + nu) * (1 - 2 * nu)); }
  double c_v() const { return k / (water_density * g) / (1 / M() + n0 / K_w); }
  double time_of(double T) const { return T * H * H / c_v(); }
};

constexpr double density = (1 - n0) * 2650 + n0 * water_density;

double root(int i) {
  return (2 * i + 1) * std::numbers::pi / 2;
}

/// Excess pressure under the load, in parts of the load. @param z  from the drained end
double pressure_under_load(double z, double T) {
  double sum = 0;
  for (int i = 0; i < 100; ++i) {
    sum += 2 / root(i) * std::sin(root(i) * z / H) * std::exp(-root(i) * root(i) * T);
  }
  return sum;
}
double degree_under_load(double T) {
  double missing = 0;
  for (int i = 0; i < 100; ++i) {
    missing += 2 / (root(i) * root(i)) * std::exp(-root(i) * root(i) * T);
  }
  return 1 - missing;
}

/// Excess pressure under the buoyant weight G H, in parts of it, when the soil is laid at once.
double pressure_under_weight(double z, double T) {
  double sum = 0;
  for (int i = 0; i < 100; ++i) {
    sum += 2 * (i % 2 == 0 ? 1 : -1) / (root(i) * root(i)) * std::sin(root(i) * z / H) *
           std::exp(-root(i) * root(i) * T);
  }
  return sum;
}
double degree_under_weight(double T) {
  double missing = 0;
  for (int i = 0; i < 100; ++i) {
    missing += 4 * (i % 2 == 0 ? 1 : -1) / std::pow(root(i), 3) * std::exp(-root(i) * root(i) * T);
  }
  return 1 - missing;
}

Json scene(const Drained& column) {
  const double h = H / column.cells;
  const bool loaded = column.load > 0;
  Json json = {{"dimension", 2},
               {"grid", box({0, 0}, {h, H + 2 * h}, {1, column.cells + 2}, "quad4")},
               {"analysis", "quasi_static"},
               {"gravity", {0, loaded ? -plate_g : -g}},
               {"walls", {wall("bottom", "slip"), wall("left", "slip"), wall("right", "slip")}},
               {"bodies",
                {body("soil", box({0, 0}, {h, H}, {1, column.cells}, "quad4"), 4,
                      elastic_soil("hencky_elastic", column.E, nu, density))}},
               {"locking", {{"method", "fbar"}}}};
  json["bodies"][0]["water"] = {{"porosity", n0}, {"permeability", column.k}};
  if (!loaded) return json;
  json["walls"][0]["drained"] = true;
  json["bodies"].push_back(
      body("plate", box({0, H}, {h, H + h}, {1, 1}, "quad4"), 4,
           elastic_soil("hencky_elastic", 1e9, 0, column.load / (plate_g * h))));
  return json;
}

struct State {
  double error = 0;       ///< largest of the excess pressure, over that at the start
  double settlement = 0;  ///< of the strains [m]
};

/// @param steps  to T, equal ones
State consolidate(const Drained& column, double T, int steps) {
  const bool loaded = column.load > 0;
  const auto solver = mpm_solver<2>(scene(column));
  const std::vector<Vector<2>> start = solver->points().x;
  run_steps(*solver, column.time_of(T) / steps, steps);
  const auto& points = solver->points();
  mpm::PoreWater water;
  water.porosity = n0;
  water.bulk_modulus = K_w;
  water.cavitation = 1e12;
  State result;
  for (std::int32_t p = 0; p < points.body_starts[1]; ++p) {
    result.settlement += points.V0[p] * (1 - points.J[p]) * column.cells / H;
  }
  const double scale = loaded ? column.load : (density - water_density) * g * H;
  const double top = H - result.settlement;
  for (std::int32_t p = 0; p < points.body_starts[1]; ++p) {
    const double rest = loaded ? 0 : water_density * g * (top - points.x[p][1]);
    const double excess = (water.at(points.water[p], points.J[p]).p - rest) / scale;
    const double Z = start[p][1];
    const double exact = loaded ? pressure_under_load(Z, T) : pressure_under_weight(H - Z, T);
    result.error = std::max(result.error, std::abs(excess - exact));
  }
  return result;
}

/// Values of the series at T: degree of consolidation, and the settlement in the end. Loads of 1e-3
/// M cost about 1e-3 by finite strain.
void compare(const std::string& id, const std::string& name, const Drained& column, double end,
             double (*degree)(double)) {
  for (const double T : {0.1, 0.2, 0.5}) {
    const std::string what = fmt::format("{}, 20 cells, T = {}: ", name, T);
    const State state = consolidate(column, T, 100);
    verify({.id = id,
            .what = what + "largest error of the excess pressure over that of the start",
            .exact = 0,
            .computed = state.error,
            .measure = Measure::absolute_error,
            .bound = 0.01});
    verify({.id = id,
            .what = what + "degree of consolidation",
            .exact = degree(T),
            .computed = state.settlement / end,
            .measure = Measure::absolute_error,
            .bound = 0.005});
  }
}

TEST(VW21_SmallConsolidation, column_under_a_load) {
  const Drained column{.load = 10e3};
  compare("VW21", "P1, Terzaghi", column, column.load * H / column.M(), degree_under_load);
}

/// The order in time is that of the settlement, with so many cells that they do not count; the
/// order in space that of the pressure with so many steps.
TEST(VW21_SmallConsolidation, converges) {
  const double T = 0.2;
  const auto settlement = [&](int steps) {
    return consolidate({.load = 10e3, .cells = 40}, T, steps).settlement;
  };
  const double s10 = settlement(10), s20 = settlement(20), s40 = settlement(40);
  verify({.id = "VW21",
          .what = "P1, Terzaghi, T = 0.2: order of the settlement in dt",
          .exact = 1,
          .computed = std::log2((s20 - s10) / (s40 - s20)),
          .measure = Measure::order,
          .bound = 0.9});
}

TEST(VW22_SelfWeightAtSmallStrain, column_laid_at_once) {
  const Drained column{};
  compare("VW22", "P2, under its own weight", column,
          (density - water_density) * g * H * H / (2 * column.M()), degree_under_weight);
}

}  // namespace
}  // namespace gabion::test
