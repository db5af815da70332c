// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <string>

#include "tests/support/gmsh_text.hpp"
#include "tests/unit/mpm/strength_search.hpp"

namespace gabion::test {

/// A plane slope of the height H above a layer of the same soil, on a rough base.
struct Slope {
  double cotangent = 2;         ///< horizontal by vertical
  double base = 6;              ///< depth below the toe [m]
  double toe = 10, crest = 20;  ///< level ground before and behind the slope [m]
  double unit_weight = 20e3;    ///< [N/m^3]
  double cohesion = 1e4;        ///< [Pa]
  double phi = 20, psi = 0;     ///< [deg]; phi 0: tresca
  int cells = 10;               ///< over H
};

inline constexpr double slope_height = 10;  // [m]

/// The bank above the toe: rows of parallelograms along the slope, half as long as the crest, then
/// quadrilaterals that reach to the wall.
inline GmshText bank_mesh(const Slope& slope) {
  const double h = slope_height / slope.cells, cot = slope.cotangent;
  const double wall = slope.toe + cot * slope_height + slope.crest;
  const int along = static_cast<int>(std::lround(slope.crest / (2 * h)));
  const int rest = static_cast<int>(std::lround((slope.crest + cot * slope_height) / (2 * h)));
  const int row = along + rest + 1;
  GmshText mesh;
  mesh.groups = {{2, 1, "bank"}};
  mesh.entities = {{2, 1, {1}}};
  mesh.blocks = {{2, 1, 3, {}}};
  for (int j = 0; j <= slope.cells; ++j) {
    const double face = slope.toe + cot * j * h, end = face + along * h;
    for (int i = 0; i < row; ++i) {
      const double x = i <= along ? face + i * h : end + (wall - end) * (i - along) / rest;
      mesh.nodes.push_back({x, slope.base + j * h, 0});
    }
  }
  for (int j = 0; j < slope.cells; ++j) {
    for (int i = 1; i < row; ++i) {
      const int a = j * row + i;
      mesh.blocks[0].elements.push_back({a, a + 1, a + 1 + row, a + row});
    }
  }
  return mesh;
}

inline Json slope_material(const Slope& slope) {
  constexpr double g = 10, modulus = 2e9;  // a stiffness of 10000 rho g H
  const double density = slope.unit_weight / g;
  Json material = elastic_soil(slope.phi > 0 ? "mohr_coulomb" : "tresca", modulus, 0.3, density);
  material["cohesion"] = slope.cohesion;
  if (slope.phi > 0) {
    material["friction_angle"] = slope.phi;
    material["dilation_angle"] = slope.psi;
  }
  return material;
}

/// @param mesh  file of bank_mesh()
/// @param from  factor at which the search begins
inline Json slope_scene(const Slope& slope, const std::string& mesh, double from) {
  const double h = slope_height / slope.cells;
  const double width = slope.toe + slope.cotangent * slope_height + slope.crest;
  const auto number = [h](double length) { return static_cast<int>(std::lround(length / h)); };
  const Json material = slope_material(slope);
  const Json reduction = {
      {"from", from}, {"increment", 0.1}, {"tolerance", 0.01}, {"max_displacement", 0.1}};
  return {{"dimension", 2},
          {"analysis", "quasi_static"},
          {"basis", "linear"},
          {"grid", box({0, 0}, {width, slope.base + slope_height + 2 * h},
                       {number(width), number(slope.base + slope_height) + 2}, "quad4")},
          {"walls", {wall("bottom", "fixed"), wall("left", "slip"), wall("right", "slip")}},
          {"gravity", {0, -10}},
          {"locking", {{"method", "fbar"}}},
          {"bodies",
           {body("ground",
                 box({0, 0}, {width, slope.base}, {number(width), number(slope.base)}, "quad4"), 4,
                 material),
            body("bank", {{"file", mesh}}, 4, material)}},
          {"phases", {{{"strength_reduction", reduction}}}}};
}

}  // namespace gabion::test
