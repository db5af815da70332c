// SPDX-License-Identifier: BSD-3-Clause
// A dam with upright faces between two levels of water.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/saturated_soil.hpp"

namespace gabion::test {
namespace {

constexpr double g = 9.81, k = 1e-4, L = 1, H = 1, h_1 = 0.875, h_2 = 0.25;

/// Discharge through the dam in its steady flow over k (h_1^2 - h_2^2) / (2 L), which Dupuit (1863)
/// found for small slopes and Charny (1951) showed to be exact, whatever the height of the seepage
/// face.
double discharge(int cells) {
  const double h = L / cells;
  Json json = {{"dimension", 2},
               {"grid", box({-h, 0}, {L + h, H + h}, {cells + 2, cells + 1}, "quad4")},
               {"basis", "gimp"},
               {"analysis", "quasi_static"},
               {"gravity", {0, -g}},
               {"walls", {wall("bottom", "fixed")}},
               {"bodies",
                {body("dam", box({0, 0}, {L, H}, {cells, cells}, "quad4"), 4,
                      elastic_soil("hencky_elastic", 1e9, 0.3, saturated_density))}},
               {"pools", {{{"level", h_1}, {"to", 0}}, {{"level", h_2}, {"from", L}}}},
               {"locking", {{"method", "fbar"}}}};
  json["bodies"][0]["water"] = pore_water;
  json["bodies"][0]["water"]["permeability"] = k;
  // Soil above the free surface has air in its pores, within a cell of it.
  json["bodies"][0]["water"]["suction_limit"] = water_density * g * h;
  json["bodies"][0]["initial_stress"] = {
      {"k0", 0}, {"surface", H}, {"pore_pressure", "steady_seepage"}, {"max_displacement", 0.01}};
  const auto solver = mpm_solver<2>(json);
  return solver->summary()["initial_discharge"].get<double>() * 2 * L /
         (k * (h_1 * h_1 - h_2 * h_2));
}

/// Water in the fringe under suction is in proportion to the cell, and so is what it adds.
TEST(VW31_Dam, lets_through_what_dupuit_has) {
  const double coarse = discharge(16), fine = discharge(32);
  verify({.id = "VW31",
          .what = "dam with upright faces in steady seepage, 32 cells a side: discharge over "
                  "Dupuit's",
          .exact = 1,
          .computed = fine,
          .bound = 0.04});
  verify({.id = "VW31",
          .what = "the same, 16 and 32 cells a side, extrapolated to none",
          .exact = 1,
          .computed = 2 * fine - coarse,
          .bound = 0.01});
}

}  // namespace
}  // namespace gabion::test
