// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/verification_row.hpp"
#include "tests/unit/fem/concrete_bar.hpp"

namespace gabion::test {
namespace {

// A section of 1 m x 0.5 m, 15.71 cm^2 of steel 62.5 mm below each face.
constexpr double depth = 0.5, cover = 0.0625, E_c = 32.8e9, f_t = 2.9e6, E_s = 200e9, f_y = 500e6,
                 A_s = 1.571e-3;
constexpr double zone = 0.5;  // half of the length that may crack [m]

/// Second moment of area without cracks, the steel in place of nothing: it lies in the concrete.
double stiffness_uncracked() {
  const double lever = depth / 2 - cover;
  return depth * depth * depth / 12 + 2 * A_s * E_s / E_c * lever * lever;
}

/// Moment at which the lower steel yields, cracked, plane sections: the compressed depth x from
/// x^2/2 + n A_s (x - c) = n A_s (d - x), n = E_s / E_c, then moments about the lower steel.
double yield_moment() {
  const double n = E_s / E_c, d = depth - cover, a = n * A_s;
  const double x = -2 * a + std::sqrt(4 * a * a + 2 * a * (d + cover));
  const double kappa = f_y / E_s / (d - x);
  const double concrete = 0.5 * E_c * kappa * x * x, steel = E_s * A_s * kappa * (x - cover);
  return concrete * (d - x / 3) + steel * (d - cover);
}

/// Half of a beam in four-point bending: concrete from mid-span to 0.5 m, then elastic; the load at
/// 1 m, far enough that it disturbs no concrete; the support at 1.5 m.
/// Cells are squares, `cells` through the depth; bars have nodes of their own.
GmshText beam(int cells) {
  const double h = depth / cells;
  const int of_zone = static_cast<int>(std::lround(zone / h)), columns = 3 * of_zone;
  GmshText file;
  const auto tag = [&](int i, int j) { return i * (cells + 1) + j + 1; };
  for (int i = 0; i <= columns; ++i) {
    for (int j = 0; j <= cells; ++j) file.nodes.push_back({i * h, j * h, 0});
  }
  std::vector<std::vector<int>> middle, end, load, concrete_cells, elastic_cells, low, high;
  for (int j = 0; j < cells; ++j) {
    middle.push_back({tag(0, j), tag(0, j + 1)});
    end.push_back({tag(columns, j), tag(columns, j + 1)});
  }
  load = {{tag(2 * of_zone, cells), tag(2 * of_zone + 1, cells)}};
  for (int i = 0; i < columns; ++i) {
    for (int j = 0; j < cells; ++j) {
      (i < of_zone ? concrete_cells : elastic_cells)
          .push_back({tag(i, j), tag(i + 1, j), tag(i + 1, j + 1), tag(i, j + 1)});
    }
  }
  for (auto* bar : {&low, &high}) {
    const double y = bar == &low ? cover : depth - cover;
    for (int i = 0; i <= columns; ++i) {
      file.nodes.push_back({i * h, y, 0});
      const int last = static_cast<int>(file.nodes.size());
      if (i > 0) bar->push_back({last - 1, last});
    }
  }
  int number = 0;
  const auto add = [&](int dimension, const std::string& name, int type, const auto& elements) {
    ++number;
    file.groups.push_back({dimension, number, name});
    file.entities.push_back({dimension, number, {number}});
    file.blocks.push_back({dimension, number, type, elements});
  };
  add(1, "middle", 1, middle);
  add(1, "end", 1, end);
  add(1, "load", 1, load);
  add(1, "low", 1, low);
  add(1, "high", 1, high);
  add(2, "zone", 3, concrete_cells);
  add(2, "arm", 3, elastic_cells);
  return file;
}

struct Bent {
  double first_damage = 0, at_yield = 0;  // moments [N m]
  double motion = 0;                      // kinetic over elastic energy when the steel yields
};

Json bar_of(const std::string& group) {
  return {{"group", group},       {"law", "bar"},
          {"density", 7850},      {"area", A_s},
          {"young_modulus", E_s}, {"yield_stress", f_y},
          {"embedded", true},     {"hardening_modulus", 0.8e9}};
}

/// A slow dynamic run: 1 s for a beam of some 100 Hz. In statics the balance has limit points where
/// one crack takes over from another, beyond which no solution is near.
Bent bend(int cells) {
  const TemporaryMesh mesh(beam(cells));
  Json material = elastic("concrete", E_c, 0, 2400);
  material["group"] = "zone";
  material["tensile_strength"] = f_t;
  material["fracture_energy"] = 140;
  material["compressive_strength"] = 38e6;
  material["crushing_energy"] = 54e3;
  Json rest = elastic("hencky_elastic", E_c, 0, 2400);
  rest["group"] = "arm";
  Json json = {{"dimension", 2}, {"mesh", {{"file", mesh.path()}}}, {"analysis", "dynamic"}};
  json["materials"] = {material, rest, bar_of("low"), bar_of("high")};
  json["supports"] = {{{"group", "middle"}, {"components", {"x"}}}};
  json["prescribed"] = {
      {{"group", "load"}, {"component", "y"}, {"table", {{0, 0}, {0.4, -0.28e-3}, {1, -2.6e-3}}}},
      {{"group", "end"}, {"component", "y"}, {"table", {{0, 0}}}}};
  const double h = depth / cells;
  json["sections"] = {{{"name", "s"}, {"point", {0.25 + 0.4 * h, depth / 2}}, {"normal", {1, 0}}}};
  const auto solver = fem_solver<2>(json);
  Bent bent;
  double before = 0;
  constexpr int steps = 512;  // a power of two: parts of steps sum exactly
  for (int n = 1; n <= steps && bent.at_yield == 0; ++n) {
    advance(*solver, n, 1.0 / steps);
    const double moment = std::abs(probe(*solver, "s.M_z"));
    if (bent.first_damage == 0 && probe(*solver, "damage_work") > 0) {
      bent.first_damage = 0.5 * (before + moment);
    }
    if (probe(*solver, "stress_max_low") > f_y) {
      bent.at_yield = moment;
      bent.motion = probe(*solver, "kinetic_energy") / probe(*solver, "elastic_energy");
    }
    before = moment;
  }
  return bent;
}

/// The steel yields near the moment of the cracked section; concrete between cracks bears a share.
/// Damage starts where the outer quadrature points reach the strength: those of cells of size h lie
/// h (1 - 1/sqrt(3)) / 2 below the face, so that the moment tends to f_t W with h. Cells of full
/// integration bend too stiffly by G/E (h / depth)^2, G/E = 1/2.
TEST(VC1_ReinforcedSection, cracking_and_yield_moment) {
  const double at_face = f_t * stiffness_uncracked() / (depth / 2);
  double coarse = 0;
  for (const int cells : {4, 8, 16}) {
    const Bent bent = bend(cells);
    const double h = depth / cells, y = depth / 2 - 0.5 * h * (1 - 1 / std::sqrt(3.0));
    verify({.id = "VC1",
            .what = fmt::format("{} cells through the depth: moment at first damage", cells),
            .exact = f_t * stiffness_uncracked() / y * (1 + 0.5 / (cells * cells)),
            .computed = bent.first_damage,
            .bound = 0.015,
            .unit = "N m"});
    const double error = bent.first_damage / at_face - 1;
    if (coarse != 0) {
      verify({.id = "VC1",
              .what = fmt::format("order of the cracking moment f_t W, {} to {} cells", cells / 2,
                                  cells),
              .exact = 1,
              .computed = std::log2(coarse / error),
              .bound = 0.35,
              .unit = ""});
    }
    coarse = error;
    EXPECT_LT(bent.motion, 1e-3) << cells;
    verify({.id = "VC1",
            .what = fmt::format("{} cells through the depth: moment when the steel yields", cells),
            .exact = yield_moment(),
            .computed = bent.at_yield,
            .bound = cells == 4   ? 0.20
                     : cells == 8 ? 0.08
                                  : 0.04,
            .unit = "N m"});
  }
}

}  // namespace
}  // namespace gabion::test
