// SPDX-License-Identifier: BSD-3-Clause
// Soil whose pore water drains, against closed forms and tables of consolidation.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {
namespace {

constexpr double nu = 0.2, water_density = 1000, K_w = 2.2e9, plate_g = 1e-3;

mpm::PoreWater water_of(double porosity) {
  mpm::PoreWater water;
  water.porosity = porosity;
  water.bulk_modulus = K_w;
  water.cavitation = 1e12;
  return water;
}

/// A column 1 m high between smooth walls, pressed together by its weight or under a plate.
struct Column {
  double E, k, porosity, density;
  std::string basis, law;
  int cells = 20;
  double load = 0;  ///< under a plate, the base drained; 0: under its own weight, the top drained
};

Json column_scene(const Column& column) {
  const double h = 1.0 / column.cells;
  Json json = {{"dimension", 2},
               {"grid", box({0, 0}, {h, 1 + 2 * h}, {1, column.cells + 2}, "quad4")},
               {"basis", column.basis},
               {"analysis", "quasi_static"},
               {"gravity", {0, column.load > 0 ? -plate_g : -9.81}},
               {"walls", {wall("bottom", "slip"), wall("left", "slip"), wall("right", "slip")}},
               {"bodies",
                {body("soil", box({0, 0}, {h, 1}, {1, column.cells}, "quad4"), 4,
                      elastic_soil("hencky_elastic", column.E, nu, column.density))}},
               {"locking", {{"method", "fbar"}}}};
  json["bodies"][0]["water"] = {
      {"porosity", column.porosity}, {"permeability", column.k}, {"permeability_law", column.law}};
  if (column.load > 0) {
    json["walls"][0]["drained"] = true;
    json["bodies"].push_back(
        body("plate", box({0, 1}, {h, 1 + h}, {1, 1}, "quad4"), 4,
             elastic_soil("hencky_elastic", 1e9, 0, column.load / (plate_g * h))));
  }
  return json;
}

/// State of the column: by height free of stress, pressure of the water above that of water at rest
/// below the present top.
struct Isochrone {
  std::vector<double> Z, p;
  double settlement = 0;  ///< of the strains [m]

  double at(double height) const {
    const auto above = std::ranges::upper_bound(Z, height);
    const auto i = std::clamp<std::ptrdiff_t>(above - Z.begin(), 1, std::ssize(Z) - 1);
    return p[i - 1] + (height - Z[i - 1]) / (Z[i] - Z[i - 1]) * (p[i] - p[i - 1]);
  }
};

Isochrone isochrone(const Column& column, const std::vector<Vector<2>>& start,
                    const mpm::MaterialPoints<2>& points) {
  Isochrone result;
  double volume = 0, squeezed = 0;
  const std::int32_t end = points.body_starts[1];
  for (std::int32_t p = 0; p < end; ++p) {
    volume += points.V0[p];
    squeezed += points.V0[p] * (1 - points.J[p]);
  }
  result.settlement = squeezed / volume;
  std::vector<std::pair<double, double>> rows;
  const double top = 1 - result.settlement;
  for (std::int32_t p = 0; p < end; ++p) {
    if (start[p][0] > start[0][0]) continue;  // one column of points
    const double at_rest = column.load > 0 ? 0 : water_density * 9.81 * (top - points.x[p][1]);
    const double pressure = water_of(column.porosity).at(points.water[p], points.J[p]).p;
    rows.emplace_back(start[p][1], pressure - at_rest);
  }
  std::ranges::sort(rows);
  for (const auto& [Z, p] : rows) {
    result.Z.push_back(Z);
    result.p.push_back(p);
  }
  return result;
}

/// Row of a published table at a time: pressures at distances from the drained end.
struct TableRow {
  double t;
  std::vector<double> pressures;  ///< at 0.75, 0.5, 0.25 of the height from the drained end [Pa]
  double settlement;
};

void compare(const std::string& id, const Column& column, const std::vector<TableRow>& table,
             double scale, double bound) {
  const auto solver = mpm_solver<2>(column_scene(column));
  const std::vector<Vector<2>> start = solver->points().x;
  const double dt = table.front().t / 50;
  int steps = 0;
  for (const TableRow& row : table) {
    const int end = static_cast<int>(std::lround(row.t / dt));
    run_steps(*solver, dt, end - steps, steps + 1);
    steps = end;
    const Isochrone now = isochrone(column, start, solver->points());
    double error = 0;
    for (int i = 0; i < 3; ++i) {
      const double from_drained = 0.75 - 0.25 * i;
      const double Z = column.load > 0 ? from_drained : 1 - from_drained;
      error = std::max(error, std::abs(now.at(Z) - row.pressures[i]) / scale);
    }
    const std::string what = (id == "VW1" ? "P3, " : "P4, ") + column.law + ", " + column.basis +
                             ", t " + std::to_string(static_cast<int>(row.t)) + " s: ";
    verify({.id = id,
            .what = what + "largest error of the pressure over the load",
            .exact = 0,
            .computed = error,
            .measure = Measure::absolute_error,
            .bound = bound});
    verify({.id = id,
            .what = what + "settlement",
            .exact = row.settlement,
            .computed = now.settlement,
            .bound = 0.01,
            .unit = "m"});
  }
}

/// Large strain under a load, where the settlement is a seventh of the height. Own finite volumes
/// of d lambda / dt = d/dZ[kappa / lambda d sigma' / dZ], 200 and 400 cells.
TEST(VW1_LargeStrainConsolidation, column_under_a_load) {
  const double q = 200e3;
  const auto table = [&](double t, const std::vector<double>& p, double s) {
    TableRow row{t, p, s};
    for (double& each : row.pressures) each *= q;
    return row;
  };
  for (const char* basis : {"gimp", "bspline"}) {
    Column column{.E = 9e5,
                  .k = 9.81e-6,
                  .porosity = 0.5,
                  .density = 1825,
                  .basis = basis,
                  .law = "constant",
                  .load = q};
    compare("VW1", column,
            {table(100, {.865866, .671266, .361134}, .068634),
             table(500, {.186783, .141914, .076094}, .139245)},
            q, column.basis == "gimp" ? 0.01 : 0.02);
    column.law = "kozeny_carman";
    compare("VW1", column,
            {table(100, {.933036, .809904, .531824}, .051345),
             table(500, {.470261, .375703, .217798}, .110923)},
            q, column.basis == "gimp" ? 0.01 : 0.02);
  }
}

/// Large strain under its own weight, the water leaving through the free surface, which sinks by a
/// twelfth of the height.
TEST(VW2_SelfWeightConsolidation, column_that_drains_through_its_surface) {
  const double scale = 0.2 * 40466.25;
  const auto table = [&](double t, const std::vector<double>& p, double s) {
    TableRow row{t, p, s};
    for (double& each : row.pressures) each *= scale;
    return row;
  };
  for (const char* basis : {"gimp", "bspline"}) {
    Column column{.E = 36419.625,
                  .k = 2.42424e-4,
                  .porosity = 0.5,
                  .density = 1825,
                  .basis = basis,
                  .law = "constant"};
    compare("VW2", column,
            {table(100, {.577487, .437103, .232792}, .019776),
             table(500, {.162563, .127935, .071423}, .067044)},
            scale, 0.01);
    column.law = "kozeny_carman";
    compare("VW2", column,
            {table(100, {.581266, .433720, .229608}, .019691),
             table(500, {.198422, .145583, .074597}, .064105)},
            scale, 0.01);
  }
}

/// Terzaghi's equation for a layer under its own weight, in explicit steps: excess pressures by the
/// buoyant weight, and the share of the settlement, 1 - 4 sum (-1)^i / l^3 exp(-l^2 T).
TEST(VW9_FractionalStep, layer_that_drains_as_it_moves) {
  const Column column{.E = 10e6,
                      .k = 1e-4,
                      .porosity = 0.4,
                      .density = 1990,
                      .basis = "gimp",
                      .law = "constant",
                      .cells = 10};
  Json json = column_scene(column);
  json.erase("analysis");
  json["time_integration"] = {{"scheme", "explicit"}};
  const double M = 10e6 * (1 - nu) / ((1 + nu) * (1 - 2 * nu)), G = 990 * 9.81;
  const auto solver = mpm_solver<2>(json);
  const std::vector<Vector<2>> start = solver->points().x;
  const double dt = 1e-3;
  int steps = 0;
  for (const auto& [T, base, middle, degree] : {std::array{.1, .643177, .440874, .197746}}) {
    const double t = T * water_density * 9.81 / (column.k * M);
    const int end = static_cast<int>(std::lround(t / dt));
    run_steps(*solver, dt, end - steps, steps + 1);
    steps = end;
    const Isochrone now = isochrone(column, start, solver->points());
    const double error =
        std::max(std::abs(now.p.front() / G - base), std::abs(now.at(0.5) / G - middle));
    const std::string what = fmt::format("P2, explicit, T {:g}: ", T);
    verify({.id = "VW9",
            .what = what + "largest error of the excess pressure, of the buoyant weight",
            .exact = 0,
            .computed = error,
            .measure = Measure::absolute_error,
            .bound = 0.01});
    verify({.id = "VW9",
            .what = what + "share of the settlement",
            .exact = degree,
            .computed = now.settlement / (G / (2 * M)),
            .measure = Measure::absolute_error,
            .bound = 0.01});
  }
}

/// Mandel (1953): a strip between rigid smooth plates, pressed by a force, drains at its sides. The
/// middle first gets more pressure, since the sides that drain give way: the mark of coupling.
struct Mandel {
  static constexpr double a = 1, F = 1e4, E = 10e6, kappa = 1e-10, M = 11.1111111e6;
  std::vector<double> roots;  ///< of tan(x) = (1 - nu) / (nu_u - nu) x, nu_u = 1 / 2

  Mandel() {
    const double eta = (1 - nu) / (0.5 - nu);
    for (int i = 0; i < 200; ++i) {
      double low = i * M_PI + 1e-9, high = i * M_PI + M_PI / 2 - 1e-9;
      for (int k = 0; k < 200; ++k) {
        const double x = 0.5 * (low + high);
        (std::tan(x) < eta * x ? low : high) = x;
      }
      roots.push_back(0.5 * (low + high));
    }
  }
  static double share(double x) { return std::sin(x) / (x - std::sin(x) * std::cos(x)); }
  double time_of(double T) const { return T * a * a / (kappa * M); }
  double pressure(double x, double t) const {
    double sum = 0;
    for (const double r : roots) {
      sum += share(r) * (std::cos(r * x / a) - std::cos(r)) * decay(r, t);
    }
    return 2 * p0() * sum;
  }
  double decay(double r, double t) const { return std::exp(-r * r * t * kappa * M / (a * a)); }
  static double p0() { return F * 1.5 / (3 * a); }
  /// Settlement of the plate over the height of the strip.
  double plate(double t) const {
    const double G = E / (2 * (1 + nu));
    double sum = 0;
    for (const double r : roots) sum += share(r) * std::cos(r) * decay(r, t);
    return F / (2 * G * a) * ((1 - nu) - sum);
  }
};

/// The plate goes down as the closed form has it, so the force is a result.
void press(const std::string& basis, double offset) {
  const Mandel mandel;
  const int cells = 10;
  const double h = 1.0 / cells, height = 2 * h;
  // The grid is stretched to put the side of the strip at a part of a cell.
  const double spacing = h / (1 + offset * h);
  const int across = cells + 3;
  Json json = {{"dimension", 2},
               {"grid", box({0, 0}, {across * spacing, height}, {across, 2}, "quad4")},
               {"basis", basis},
               {"analysis", "quasi_static"},
               {"gravity", {0, 0}},
               {"walls", {wall("left", "slip"), wall("bottom", "slip"), wall("top", "slip")}},
               {"bodies",
                {body("strip", box({0, 0}, {1, height}, {cells, 2}, "quad4"), 4,
                      elastic_soil("hencky_elastic", Mandel::E, nu, 1990))}},
               {"locking", {{"method", "fbar"}}},
               {"probes", {{{"name", "side"}, {"point", {1, 0.5 * height}}}}}};
  json["bodies"][0]["water"] = {{"porosity", 0.4},
                                {"permeability", Mandel::kappa * water_density * 9.81}};
  const int steps = 100;
  const double end = mandel.time_of(0.5), dt = end / steps;
  Json motion = Json::array({{0, 0, 0}});
  for (int k = 1; k <= steps; ++k) motion.push_back({k * dt, 0, -height * mandel.plate(k * dt)});
  json["walls"][2]["motion"] = {{"table", motion}};
  const auto solver = mpm_solver<2>(json);
  const std::string what =
      basis + ", side at " + std::to_string(offset).substr(0, 4) + " of a cell";
  double pressure_error = 0, force_error = 0, largest = 0;
  for (int k = 1; k <= steps; ++k) {
    run_steps(*solver, dt, 1, k);
    const auto& points = solver->points();
    double error = 0;
    for (std::int32_t p = 0; p < points.size(); ++p) {
      const double pressure = water_of(0.4).at(points.water[p], points.J[p]).p;
      largest = std::max(largest, pressure / mandel.p0());
      error = std::max(error, std::abs(pressure - mandel.pressure(points.x[p][0], k * dt)));
    }
    if (k < steps / 10) continue;  // from T = 0.05 on
    pressure_error = std::max(pressure_error, error / mandel.p0());
    force_error = std::max(force_error, std::abs(probe(*solver, "wall.top.fy") / Mandel::F - 1));
  }
  verify({.id = "VW3",
          .what = "P5, " + what + ": largest error of the pressure from T = 0.05 on",
          .exact = 0,
          .computed = pressure_error,
          .measure = Measure::absolute_error,
          .bound = basis == "bspline" && offset == 0 ? 0.05 : 0.025});
  verify({.id = "VW3",
          .what = "P5, " + what + ": largest error of the force on the plate",
          .exact = 0,
          .computed = force_error,
          .measure = Measure::absolute_error,
          .bound = 0.005});
  verify({.id = "VW3",
          .what = "P5, " + what + ": largest pressure in the middle",
          .exact = 1.106896,
          .computed = largest,
          .bound = 0.01});
}

TEST(VW3_Mandel, strip_that_drains_through_its_free_side) {
  for (const char* basis : {"gimp", "bspline"}) {
    for (const double offset : {0.0, 1.0 / 3, 0.5}) press(basis, offset);
  }
}

}  // namespace
}  // namespace gabion::test
