// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {

inline const Json pore_water = {{"porosity", 0.4}, {"bulk_modulus", 2.2e9}};
inline constexpr double saturated_density = 1990, water_density = 1000, porosity = 0.4;

inline Json saturated_elastic(const std::string& law = "hencky_elastic") {
  return elastic_soil(law, 20e6, 0.3, saturated_density);
}
inline Json saturated_sand(double dilation = 0) {
  Json soil = elastic_soil("mohr_coulomb", 20e6, 0.3, saturated_density);
  soil["friction_angle"] = 32;
  soil["dilation_angle"] = dilation;
  return soil;
}

/// Soil with pore water that fills a box of `cells` cells of size h with a row of free cells beside
/// and above it, between smooth walls on all other sides.
inline Json saturated_box(int dim, const std::string& type, int cells, const Json& material) {
  const double h = 1.0 / cells;
  std::vector<double> low(dim, 0.0), high(dim, 1.0), top(dim, 1.0), gravity(dim, 0.0);
  std::vector<int> count(dim, cells), grid_count(dim, cells);
  top[dim - 1] = 1 + h;
  grid_count[dim - 1] = cells + 1;
  gravity[dim - 1] = -9.81;
  Json json = {{"dimension", dim},
               {"grid", box(low, top, grid_count, type)},
               {"gravity", gravity},
               {"walls", {wall("bottom", "slip"), wall("left", "slip"), wall("right", "slip")}},
               {"bodies", {body("soil", box(low, high, count, type), 1 << dim, material)}},
               {"newton", exact_newton}};
  if (type == "tri3") json["bodies"][0]["points_per_cell"] = 3;
  if (dim == 3) {
    json["walls"].push_back(wall("front", "slip"));
    json["walls"].push_back(wall("back", "slip"));
  }
  json["bodies"][0]["water"] = pore_water;
  return json;
}

/// Initial stress of that box.
inline Json at_rest(double table, double k0 = 0.5) {
  return {{"k0", k0}, {"surface", 1}, {"water_table", table}};
}

}  // namespace gabion::test
