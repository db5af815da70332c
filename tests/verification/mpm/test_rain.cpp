// SPDX-License-Identifier: BSD-3-Clause
// Water that comes into full pores: rain on the surface, a water table that rises from below.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/saturated_soil.hpp"

namespace gabion::test {
namespace {

constexpr double pi = 3.14159265358979324, g = 9.81, gamma_w = water_density * g;
constexpr double k = 1e-6, nu = 0.2, E = 10e6, M = 11.1111111e6, K_w = 2.2e9;
constexpr double c_v = k / gamma_w / (1 / M + porosity / K_w);

/// A column 1 m high between smooth walls whose base is drained. Its surface is in air.
Json column(const std::string& basis, int cells) {
  const double h = 1.0 / cells;
  Json json = {{"dimension", 2},
               {"grid", box({0, 0}, {h, 1 + 2 * h}, {1, cells + 2}, "quad4")},
               {"basis", basis},
               {"analysis", "quasi_static"},
               {"gravity", {0, -g}},
               {"walls", {wall("bottom", "slip"), wall("left", "slip"), wall("right", "slip")}},
               {"bodies",
                {body("soil", box({0, 0}, {h, 1}, {1, cells}, "quad4"), 4,
                      elastic_soil("hencky_elastic", E, nu, saturated_density))}},
               {"locking", {{"method", "fbar"}}}};
  json["walls"][0]["drained"] = true;
  json["bodies"][0]["water"] = pore_water;
  json["bodies"][0]["water"]["permeability"] = k;
  return json;
}

/// A run whose steps grow.
struct ColumnRun {
  std::unique_ptr<mpm::MpmSolver<2>> solver;
  double time = 0;
  int step = 0;

  explicit ColumnRun(const Json& json) : solver(mpm_solver<2>(json)) {}
  void to(double end, int steps) {
    const double dt = (end - time) / steps;
    for (int i = 0; i < steps; ++i, time += dt) {
      const StepRequest request{++step, 0, time, dt};
      InterfaceValues sent;
      solver->solve_step(request, {}, sent);
      solver->accept_step(request, true);
    }
  }
  double mass() const {
    double sum = 0;
    for (const double m : solver->points().m) sum += m;
    return sum;
  }
  /// Largest error of the pressure over gamma_w H. @param exact  by height
  template <class Exact>
  double error(const Exact& exact) const {
    mpm::PoreWater water;
    water.porosity = porosity;
    water.bulk_modulus = K_w;
    water.cavitation = 1e12;
    const auto& points = solver->points();
    double largest = 0;
    for (std::int32_t p = 0; p < points.size(); ++p) {
      const double found = water.at(points.water[p], points.J[p]).p;
      largest = std::max(largest, std::abs(found - exact(points.x[p][1])) / gamma_w);
    }
    return largest;
  }
};

void expect_zero(const std::string& id, const std::string& what, double found, double bound) {
  verify({.id = id,
          .what = what,
          .exact = 0,
          .computed = found,
          .measure = Measure::absolute_error,
          .bound = bound});
}

/// Part of the steady change of the pressure that a flux into the top has brought by height z over
/// the height, T = c_v t / H^2 (Carslaw, Jaeger 1959, 3.8).
double infiltrated(double z, double T) {
  double sum = z;
  for (int n = 0; n < 200; ++n) {
    const double l = (2 * n + 1) * pi / 2;
    sum -= (n % 2 == 0 ? 2 : -2) / (l * l) * std::exp(-l * l * T) * std::sin(l * z);
  }
  return sum;
}

/// Water hangs over the drained base; rain of less than the permeability then brings the gradient
/// rho_w g (1 - i / k), and the column takes all of it. In water: stored + out.
TEST(VW5_Rain, weaker_than_the_permeability) {
  for (const char* basis : {"gimp", "bspline"}) {
    const double start = 1e7, rate = 0.5 * k, hour = 1 / c_v;
    Json json = column(basis, 20);
    json["rain"] = {{"table", {{start, 0}, {start + 1, rate}}}};
    ColumnRun run(json);
    run.to(start, 4);
    const std::string what = std::string("rain of k / 2 on a column, ") + basis;
    expect_zero("VW5", what + ": largest error of the pressure before it, over that of the column",
                run.error([](double z) { return -gamma_w * z; }), 1e-3);
    const double before = run.mass(), out = probe(*run.solver, "water_out");
    const double in = probe(*run.solver, "rain_in");
    for (const double T : {0.05, 0.2, 1.0}) {
      run.to(start + T * hour, T == 1 ? 80 : 50);
      expect_zero("VW5", fmt::format("{}, T = {:g}: largest error of the pressure", what, T),
                  run.error([&](double z) { return gamma_w * (rate / k * infiltrated(z, T) - z); }),
                  5e-3);
    }
    const double taken = probe(*run.solver, "rain_in") - in;
    verify({.id = "VW5",
            .what = what + ": water that the soil took",
            .exact = rate * (run.time - start) / 20 * water_density,
            .computed = taken,
            .bound = 1e-3,
            .unit = "kg/m"});
    const double stored = run.mass() - before;
    expect_zero("VW5", what + ": water in minus stored and out, over water in",
                (taken - stored - (probe(*run.solver, "water_out") - out)) / taken, 1e-6);
  }
}

/// Rain of twice the permeability: soil takes k, up to what the surface of (W15) holds back, under
/// no pressure anywhere, and the rest runs off.
TEST(VW5_Rain, stronger_than_the_permeability) {
  for (const char* basis : {"gimp", "bspline"}) {
    const double start = 1e7, end = 2e7;
    Json json = column(basis, 20);
    json["rain"] = {{"table", {{start, 0}, {start + 1, 2 * k}}}};
    ColumnRun run(json);
    run.to(start, 4);
    run.to(start + 0.2 / c_v, 40);
    run.to(end, 10);
    const double in = probe(*run.solver, "rain_in"), off = probe(*run.solver, "rain_run_off");
    run.to(end + 1e6, 2);
    const std::string what = std::string("rain of 2 k on a column, ") + basis;
    verify({.id = "VW5",
            .what = what + ": rate that the soil takes over k",
            .exact = 1 / (1 + 1.0 / (50 * 20)),
            .computed = (probe(*run.solver, "rain_in") - in) / (1e6 / 20 * water_density * k),
            .bound = std::string(basis) == "gimp" ? 2e-3 : 5e-3});
    verify({.id = "VW5",
            .what = what + ": water taken in and water that runs off, over the rain",
            .exact = 2,
            .computed =
                (probe(*run.solver, "rain_in") + probe(*run.solver, "rain_run_off") - in - off) /
                (1e6 / 20 * water_density * k),
            .bound = 1e-4});
    expect_zero("VW5", what + ": largest pressure over that of the column",
                run.error([](double) { return 0.0; }), std::string(basis) == "gimp" ? 3e-3 : 1e-2);
  }
}

/// The level behind the drained base rises from the base to three quarters of the column and stays
/// below its surface, which stays dry (Carslaw, Jaeger 1959, 3.4). In the cell that the level cuts
/// the force of the pool on the points is that of a part of the cell.
TEST(VW6_RisingTable, under_a_column) {
  const double start = 1e7, hour = 1 / c_v, risen = 0.2 * hour, level = 0.75;
  const auto exact = [&](double z, double T) {
    const double x = 1 - z, a = level / 0.2;
    double sum = a * T + a * (x * x - 1) / 2;
    for (int n = 0; n < 200; ++n) {
      const double l = (2 * n + 1) * pi / 2;
      sum += (n % 2 == 0 ? 2 : -2) * a / (l * l * l) * std::exp(-l * l * T) * std::cos(l * x);
    }
    return sum;
  };
  for (const auto& [basis, cells] : std::vector<std::pair<std::string, int>>{
           {"gimp", 20}, {"gimp", 40}, {"bspline", 20}, {"bspline", 40}}) {
    Json json = column(basis, cells);
    json["pools"] = {{{"table", {{start, 0}, {start + risen, level}}}}};
    ColumnRun run(json);
    run.to(start, 4);
    const double before = run.mass(), out = probe(*run.solver, "water_out");
    const std::string what =
        fmt::format("water table that rises under a column, {}, {} cells", basis, cells);
    for (const double T : {0.05, 0.1, 0.2}) {
      run.to(start + T * hour, 60);
      expect_zero("VW6",
                  fmt::format("{}, T = {:g}: largest error of the pressure over that of the column",
                              what, T),
                  run.error([&](double z) { return gamma_w * (exact(z, T) - z); }), 0.3 / cells);
    }
    run.to(start + 50 * hour, 6);
    expect_zero("VW6", what + ": the same at the end",
                run.error([&](double z) { return gamma_w * (level - z); }), 1e-3);
    const double stored = run.mass() - before;
    verify({.id = "VW6",
            .what = what + ": water that came in",
            .exact = gamma_w * level * (1 / M + porosity / K_w) / cells * water_density,
            .computed = out - probe(*run.solver, "water_out"),
            .bound = 0.01,
            .unit = "kg/m"});
    expect_zero("VW6", what + ": water in minus stored, over water in",
                (out - probe(*run.solver, "water_out") - stored) / stored, 1e-6);
  }
}

}  // namespace
}  // namespace gabion::test
