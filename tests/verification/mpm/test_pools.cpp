// SPDX-License-Identifier: BSD-3-Clause
// Free water over and beside saturated soil, against hydrostatics.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/saturated_soil.hpp"

namespace gabion::test {
namespace {

constexpr double g = 9.81, gamma_w = water_density * g;
constexpr double buoyant = (saturated_density - water_density) * g;

/// Saturated soil 1 m deep under a pool of this level, between a smooth side and a rigid wall.
/// @param offset  of the wall in its cell
Json scene(double level, double offset, int cells) {
  const double h = 1.0 / cells, x = 1 + offset * h;
  Json json = saturated_box(2, "quad4", cells, saturated_elastic());
  json["grid"] = box({0, 0}, {1 + 2 * h, 1 + 2 * h}, {cells + 2, cells + 2}, "quad4");
  json["bodies"][0]["mesh"] = box({0, 0}, {x, 1}, {cells + (offset > 0 ? 1 : 0), cells}, "quad4");
  json["basis"] = "gimp";
  json["bodies"][0]["water"]["permeability"] = 1e-4;
  json["bodies"][0]["initial_stress"] = at_rest(level);
  json["pools"] = {{{"level", level}}};
  json["walls"] = {wall("bottom", "slip"), wall("left", "slip")};
  json["rigid_walls"] = {{{"name", "wall"},
                          {"surface", {{"polyline", {{x, level}, {x, 0}}}, {"spacing", 0.05}}},
                          {"moment_about", {x, 0}},
                          {"friction", 0}}};
  return json;
}

/// Force rho g H^2 / 2 and moment rho g H^3 / 6 of the water, and the thrust of the grains at rest.
TEST(VW4_Pool, presses_on_a_wall_beside_soil) {
  const double level = 1.5;
  for (const double offset : {0.0, 1.0 / 3, 0.5}) {
    const auto solver = mpm_solver<2>(scene(level, offset, 8));
    run_steps(*solver, 0.02, 50);
    const double water = gamma_w * level * level / 2, soil = 0.5 * buoyant / 2;
    const std::string what =
        fmt::format("P9, pool 0.5 m above soil of 1 m, wall at {:.2f} of a cell: ", offset);
    verify({.id = "VW4",
            .what = what + "force on the wall",
            .exact = water + soil,
            .computed = probe(*solver, "wall.fx"),
            .bound = 0.01,
            .unit = "N/m"});
    verify({.id = "VW4",
            .what = what + "moment about its foot",
            .exact = water * level / 3 + soil / 3,
            .computed = std::abs(probe(*solver, "wall.mz")),
            .bound = 0.01,
            .unit = "N"});
    const double base = (buoyant + gamma_w * level) * (1 + offset / 8);
    verify({.id = "VW4",
            .what = what + "force on the base under the soil",
            .exact = base,
            .computed = -probe(*solver, "wall.bottom.fy") - gamma_w * level * (0.25 - offset / 8),
            .bound = 0.01,
            .unit = "N/m"});
  }
}

/// No node has a force: 1,000 steps with inertia under a pool, a tenth of a cell or ten metres
/// deep.
TEST(VW4_Pool, lets_soil_rest) {
  for (const double level : {1.0125, 11.0}) {
    Json json = scene(level, 0, 8);
    json.erase("rigid_walls");
    json["grid"] = box({0, 0}, {1, 1.25}, {8, 10}, "quad4");
    json["walls"].push_back(wall("right", "slip"));
    const auto solver = mpm_solver<2>(json);
    run_steps(*solver, 0.01, 1000);
    double largest = 0;
    for (const auto& u : solver->points().u) largest = std::max(largest, u.norm());
    verify({.id = "VW4",
            .what = fmt::format("P9, soil under {:g} m of water, 1000 steps: largest "
                                "displacement of a point over the size of a cell",
                                level - 1),
            .exact = 0,
            .computed = largest * 8,
            .measure = Measure::absolute_error,
            .bound = 1e-6});
  }
}

}  // namespace
}  // namespace gabion::test
