// SPDX-License-Identifier: BSD-3-Clause
// Thrust of a layer at rest on a wall that cuts triangles of the grid.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/support/cut_steps.hpp"
#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {
namespace {

constexpr double density = 2000, g = 10, k0 = 0.5;

struct Layer {
  double at = 0;   // place of the wall in its cell
  int cells = 10;  // over 1 m
  int cells_wide = 10;
  int points = 3;          // of a cell
  bool alternate = false;  // diagonals of grid and body
  std::string locking = "none";
  double E = 1e8;  // [Pa]

  double height() const { return 1 + at / cells; }
};

/// A layer between a smooth wall of the grid and one of facets. Its mesh ends at the wall, so its
/// cells are a little larger than those of the grid.
Json layer_at_rest(const Layer& layer) {
  const double h = 1.0 / layer.cells, H = layer.height(), W = (layer.cells_wide + layer.at) * h;
  Json grid = box({0, 0}, {(layer.cells_wide + 3) * h, 1 + 3 * h},
                  {layer.cells_wide + 3, layer.cells + 3}, "tri3");
  Json soil = box({0, 0}, {W, H}, {layer.cells_wide, layer.cells}, "tri3");
  grid["box"]["alternate"] = soil["box"]["alternate"] = layer.alternate;
  Json json = {
      {"dimension", 2},
      {"grid", grid},
      {"analysis", "quasi_static"},
      {"locking", {{"method", layer.locking}}},
      {"gravity", {0, -g}},
      {"walls", {wall("left", "slip"), wall("bottom", "slip")}},
      {"bodies",
       {body("soil", soil, layer.points, elastic_soil("hencky_elastic", layer.E, 0.3, density))}},
      {"rigid_walls",
       {{{"name", "wall"},
         {"surface", {{"polyline", {{W, 1 + 2 * h}, {W, -1}}}, {"spacing", h}}},
         {"mode", "slip"},
         {"penalty_factor", 1e4}}}}};
  json["bodies"][0]["initial_stress"] = {{"k0", k0}, {"surface", H}, {"max_displacement", 0.01}};
  return json;
}

/// The wall does not move, so the thrust remains K0 rho g H^2 / 2. A stiff contact: a soft one
/// would hide what the soil lacks.
void check_thrust(const Layer& layer) {
  const auto solver = make_mpm(layer_at_rest(layer));
  run_steps(*solver, 0.5, 2);
  const double W = 1 + layer.at / layer.cells;
  verify({.id = "V12",
          .what = fmt::format("K0 box, force on a wall by facets at {:.2g} of a cell of triangles, "
                              "{}{} cells a metre, locking {}",
                              layer.at, layer.alternate ? "alternate, " : "", layer.cells,
                              layer.locking),
          .exact = k0 * density * g * W * W / 2,
          .computed = probe(*solver, "wall.fx"),
          .bound = layer.alternate && layer.locking == "fbar" ? 0.012 : 0.01,
          .unit = "N"});
}

TEST(V12_CutCells, thrust_of_elastic_soil_on_triangles) {
  for (const double at : {0.0, 0.25, 1.0 / 3, 0.5}) {
    for (const int cells : {10, 20}) {
      for (const bool alternate : {false, true}) {
        check_thrust({.at = at, .cells = cells, .alternate = alternate});
        check_thrust({.at = at, .cells = cells, .alternate = alternate, .locking = "fbar"});
      }
    }
  }
}

/// Sand gives way where contact and stress ask different forces of a node; the layer is narrow, so
/// little of that takes much of the thrust.
void check_thrust_of_sand(const Layer& layer) {
  Json json = layer_at_rest(layer);
  json.erase("analysis");
  json["bodies"][0]["material"] = elastic_soil("mohr_coulomb", layer.E, 0.3, density);
  json["bodies"][0]["material"]["friction_angle"] = 35;
  json["rigid_walls"][0]["penalty_factor"] = 10;
  const auto solver = make_mpm(json);
  run_with_cuts(*solver, {.end = 0.2, .dt = 0.01, .dt_min = 1e-4});
  const double H = layer.height();
  verify({.id = "V12",
          .what = fmt::format("K0 box, force on a wall by facets at {:.2g} of a cell of {} "
                              "triangles, {} points a cell, Mohr-Coulomb, locking {}, after 0.2 s",
                              layer.at, layer.alternate ? "alternate" : "equal", layer.points,
                              layer.locking),
          .exact = k0 * density * g * H * H / 2,
          .computed = probe(*solver, "wall.fx"),
          .bound = layer.locking == "none" ? 0.035 : 0.015,
          .unit = "N"});
}

TEST(V12_CutCells, thrust_of_sand_on_triangles) {
  for (const double at : {0.0, 0.25, 1.0 / 3, 0.5}) {
    for (const int points : {3, 12}) {
      for (const std::string locking : {"none", "fbar"}) {
        for (const bool alternate : {false, true}) {
          check_thrust_of_sand({.at = at,
                                .cells_wide = 5,
                                .points = points,
                                .alternate = alternate,
                                .locking = locking,
                                .E = 2e7});
        }
      }
    }
  }
}

}  // namespace
}  // namespace gabion::test
