// SPDX-License-Identifier: BSD-3-Clause
// Energy of reinforced concrete whose cracks open and close many times.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/fem/concrete_bar.hpp"
#include "tests/unit/fem/energy_balance.hpp"

namespace gabion::test::test_closing_cracks {
namespace {

constexpr double length = 3, depth = 0.5;

/// A cantilever of 12 x 2 squares with steel along both of its faces.
GmshText reinforced_cantilever() {
  constexpr int columns = 12, rows = 2;
  GmshText file;
  const auto tag = [](int i, int j) { return i * (rows + 1) + j + 1; };
  std::vector<std::vector<int>> left, right, steel, cells;
  for (int i = 0; i <= columns; ++i) {
    for (int j = 0; j <= rows; ++j) {
      file.nodes.push_back({length * i / columns, depth * j / rows, 0});
      if (i < columns && j < rows) {
        cells.push_back({tag(i, j), tag(i + 1, j), tag(i + 1, j + 1), tag(i, j + 1)});
      }
      if (i < columns && j != 1) steel.push_back({tag(i, j), tag(i + 1, j)});
      if (j < rows && i == 0) left.push_back({tag(i, j), tag(i, j + 1)});
      if (j < rows && i == columns) right.push_back({tag(i, j), tag(i, j + 1)});
    }
  }
  file.groups = {{1, 1, "left"}, {1, 2, "right"}, {1, 3, "steel"}, {2, 4, "wall"}};
  file.entities = {{1, 1, {1}}, {1, 2, {2}}, {1, 3, {3}}, {2, 1, {4}}};
  file.blocks = {{1, 1, 1, left}, {1, 2, 1, right}, {1, 3, 1, steel}, {2, 1, 3, cells}};
  return file;
}

struct Swing {
  double work = 0;    // that came in [J]
  double gained = 0;  // most energy beyond it at any time [J]
  double at_end = 0;  // energy beyond it at the end [J]
  double damage = 0;  // taken by cracks [J]
  int turns = 0;      // that the tip passed its place of rest
};

/// The cantilever is pushed for 20 ms, cracks on its one side, then on the other, and swings on.
Json pushed_cantilever(const std::string& file, double nu, double push) {
  Json material = concrete("wall");
  material["poisson_ratio"] = nu;
  material["crack_spacing"] = 0.2;
  Json json = {{"dimension", 2}, {"mesh", {{"file", file}}}};
  json["materials"] = {material,
                       {{"group", "steel"},
                        {"law", "bar"},
                        {"density", 5450},
                        {"young_modulus", 200e9},
                        {"area", 1.571e-3},
                        {"yield_stress", 500e6}}};
  json["supports"] = {{{"group", "left"}}};
  json["tractions"] = {{{"group", "right"},
                        {"traction", {0, push / depth}},
                        {"table", {{0, 0}, {0.01, 1}, {0.02, 0}}}}};
  json["probes"] = {{{"name", "tip"}, {"point", {length, 0}}}};
  json["newton"] = {{"residual_tolerance", 1e-10}};
  return json;
}

/// @param dt  a power of two, so that parts of steps sum exactly
Swing swing(double nu, double push, double dt) {
  const TemporaryMesh mesh(reinforced_cantilever());
  const auto solver = fem_solver<2>(pushed_cantilever(mesh.path(), nu, push));
  Swing found;
  double before = 0;
  for (int n = 1; n * dt <= 0.5; ++n) {
    advance(*solver, n, dt);
    const double tip = probe(*solver, "tip.uy");
    if (tip * before < 0) ++found.turns;
    before = tip;
    found.at_end = imbalance(*solver);
    found.gained = std::max(found.gained, found.at_end);
  }
  found.work = probe(*solver, "external_work");
  found.damage = probe(*solver, "damage_work");
  return found;
}

TEST(ClosingCracks, make_no_energy) {
  for (const double nu : {0.0, 0.2}) {
    for (const double push : {120e3, 200e3}) {
      const Swing swung = swing(nu, push, 1.0 / 2048);
      EXPECT_LT(swung.gained, 0.001 * swung.work) << nu << " " << push;
      EXPECT_GT(swung.damage, 0.2 * swung.work) << nu << " " << push;
      EXPECT_GE(swung.turns, 6) << nu << " " << push;
    }
  }
}

/// In steps in which many cracks form at once the velocities at their ends swing over, but what
/// came in bounds the energy afterwards.
TEST(ClosingCracks, make_no_energy_in_long_steps) {
  for (const double nu : {0.0, 0.2}) {
    for (const double push : {60e3, 120e3, 200e3}) {
      const Swing swung = swing(nu, push, 1.0 / 512);
      EXPECT_LT(swung.at_end, 0) << nu << " " << push;
      EXPECT_GE(swung.turns, 6) << nu << " " << push;
    }
  }
}

}  // namespace
}  // namespace gabion::test::test_closing_cracks
