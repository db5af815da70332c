// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "coupler/checks/surface_check.hpp"
#include "coupler/mapping/surface_extent.hpp"
#include "tests/support/expect_error.hpp"

namespace gabion::test_surface_check {
namespace {

/// A wall of this height [m] whose foot is at (x, 0), in `pieces` segments; soil on its left.
InterfaceMesh wall(double x, double height, int pieces) {
  InterfaceMesh mesh;
  mesh.name = "wall";
  mesh.dim = 2;
  mesh.vertices_per_facet = 2;
  for (int i = 0; i <= pieces; ++i) {
    mesh.coordinates.insert(mesh.coordinates.end(), {x, height * (pieces - i) / pieces});
    if (i > 0) mesh.facets.insert(mesh.facets.end(), {i - 1, i});
  }
  return mesh;
}

void pair_up(const InterfaceMesh& structure, const InterfaceMesh& soil) {
  MappingSettings settings;
  settings.tolerance = 1e-6;
  const InterfaceMap map({{"wall", "soil", "structure"}},
                         {{"soil", {soil}}, {"structure", {structure}}}, settings);
  EXPECT_EQ(map.soil_size(), std::ssize(soil.coordinates));
}

TEST(SurfaceCheck, millimetres_on_one_side_are_named_when_the_surfaces_are_apart) {
  test::expect_error<ConfigError>(
      [] { pair_up(wall(250, 50, 4), wall(0.25, 0.05, 5)); },
      {"m away from the structure's surface",
       "the structure's surface extends over 50, the soil's over 0.05, a factor of about 1000: one "
       "of them seems to be in millimetres"});
  test::expect_error<ConfigError>([] { pair_up(wall(0.25, 0.05, 4), wall(250, 50, 5)); },
                                  {"over 0.05, the soil's over 50, a factor"});
}

TEST(SurfaceCheck, units_are_not_named_without_a_reason) {
  pair_up(wall(0.25, 0.05, 4), wall(0.25, 0.05, 5));
  const std::string apart =
      test::error_of<ConfigError>([] { pair_up(wall(0.26, 0.05, 4), wall(0.25, 0.05, 5)); });
  test::expect_parts(apart, {"m away"});
  EXPECT_EQ(apart.find("millimetres"), std::string::npos);
  EXPECT_EQ(unit_hint(wall(0, 0.05, 4), wall(0, 5, 4)), "");   // 100
  EXPECT_EQ(unit_hint(wall(0, 0.05, 4), wall(0, 45, 4)), "");  // 900
  EXPECT_NE(unit_hint(wall(0, 0.05, 4), wall(0, 49, 4)), "");  // 980: a facet shorter
}

/// The wall with a layer of cells of this thickness [m] behind it, on its right.
InterfaceMesh with_cells_behind(InterfaceMesh mesh, double thickness) {
  const std::vector<double> front = mesh.coordinates;
  for (std::size_t k = 0; k < front.size(); k += 2) {
    mesh.coordinates.insert(mesh.coordinates.end(), {front[k] + thickness, front[k + 1]});
  }
  return mesh;
}

/// Cells behind the surface on one side alone, or more there, are named with both files.
TEST(SurfaceCheck, cells_behind_one_side_alone_are_named_when_the_surfaces_are_apart) {
  const InterfaceMesh bare = wall(0.25, 0.05, 4), deep = with_cells_behind(bare, 0.01);
  pair_up(deep, deep);
  pair_up(deep, bare);
  test::expect_error<ConfigError>(
      [&] { pair_up(bare, deep); },
      {"interface \"wall\": soil vertex 5 at", "m away", "; 5 vertices of the soil's side and 0 of",
       "equal \"behind\" in the surface of mpm.json and in the interface of fem.json"});
  test::expect_error<ConfigError>([&] { pair_up(deep, with_cells_behind(deep, 0.02)); },
                                  {"15 vertices of the soil's side and 5 of the structure's"});
  test::expect_error<ConfigError>(
      [&] { pair_up(with_cells_behind(wall(0.26, 0.05, 4), 0.01), bare); },
      {"0 vertices of the soil's side and 5 of the structure's"});
  const std::string apart =
      test::error_of<ConfigError>([&] { pair_up(wall(0.26, 0.05, 4), bare); });
  EXPECT_EQ(apart.find("behind"), std::string::npos);
}

std::vector<std::string> warnings(const CouplingSettings& coupling, double x) {
  return rounding_warnings(coupling, {wall(x, 0.05, 4)}, "coupler.json");
}

TEST(SurfaceCheck, tolerances_below_the_rounding_of_positions_are_named) {
  CouplingSettings coupling;
  coupling.mapping.tolerance = 1e-9;
  coupling.convergence.displacement = {1e-9, 1e-5, 1e-9, {}};
  EXPECT_TRUE(warnings(coupling, 0.25).empty());
  EXPECT_TRUE(warnings(coupling, 1e6).empty());  // 4 eps 1e6 m = 8.9e-10 m
  const auto found = warnings(coupling, 2e6);
  ASSERT_EQ(found.size(), 3u);
  EXPECT_NE(found[0].find("coupler.json: at /coupling/mapping/tolerance: found 1e-09 m, below the "
                          "rounding of coordinates up to 2e+06 m, which is 1.8e-09 m"),
            std::string::npos)
      << found[0];
  EXPECT_NE(found[1].find("at /coupling/convergence/displacement/absolute: "), std::string::npos);
  EXPECT_NE(found[2].find("at /coupling/convergence/displacement/floor: "), std::string::npos);
}

TEST(SurfaceCheck, criteria_that_are_not_given_are_not_judged) {
  CouplingSettings coupling;
  coupling.mapping.tolerance = 1e-6;
  coupling.convergence.force = {1e-30, 1e-5, 1e-30, {}};  // nobody knows the rounding of forces
  coupling.convergence.displacement.relative = 1e-5;      // floor 0: not asked for
  EXPECT_TRUE(warnings(coupling, 2e6).empty());
}

}  // namespace
}  // namespace gabion::test_surface_check
