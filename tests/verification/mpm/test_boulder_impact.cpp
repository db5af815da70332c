// SPDX-License-Identifier: BSD-3-Clause
// A boulder against a wall of finite elements, through the coupling loop.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"
#include "tests/verification/mpm/coupled_run.hpp"

namespace gabion::test {
namespace {

/// A sphere of rock hits the tip of a cantilever of concrete.
constexpr double R = 0.5, rock = 2650, v0 = 5, gap = 0.004;
constexpr double L = 3, width = 1, thickness = 0.5, E = 30e9, concrete = 2500;
constexpr double dt = 1.25e-4;
const double m = 4 * M_PI / 3 * R * R * R * rock;

/// @param surface  key of the wall in mpm.json: interfaces or rigid_walls
Json soil_settings(const std::string& surface) {
  Json json = {{"dimension", 3},
               {"grid", box({-2, -0.5, 0}, {1, 1.5, 4}, {12, 8, 16}, "hex8")},
               {"time_integration", {{"scheme", "explicit"}}},
               {"bodies",
                {body("soil", box({-0.51, 0.25, 0.5}, {-0.01, 0.75, 1}, {2, 2, 2}, "hex8"), 8,
                      elastic_soil("neo_hookean", 1e6, 0.3, 1800))}},
               {surface,
                {{{"name", "wall"},
                  {"surface",
                   {{"mesh", box({0, 0, 0}, {thickness, width, L}, {1, 4, 12}, "hex8")},
                    {"groups", {"left"}}}}}}},
               {"boulders",
                {{{"name", "stone"},
                  {"shape", {{"radius", R}}},
                  {"density", rock},
                  {"centre", {-R - gap, 0.5 * width, L - 0.001}},
                  {"velocity", {v0, 0, 0}},
                  {"friction", 0},
                  {"restitution", 1},
                  {"stiffness", 2.5e11}}}}};
  return json;
}

Json wall_settings(double modulus) {
  return {{"dimension", 3},
          {"mesh", box({0, 0, 0}, {thickness, width, L}, {2, 4, 12}, "hex8")},
          {"material",
           {{"law", "neo_hookean"},
            {"density", concrete},
            {"young_modulus", modulus},
            {"poisson_ratio", 0},
            {"formulation", "enhanced"}}},
          {"time_integration", {{"scheme", "bossak"}}},
          {"supports", {{{"group", "bottom"}, {"report_reaction", true}}}},
          {"interfaces", {{{"name", "wall"}, {"groups", {"left"}}}}},
          {"probes", {{{"name", "tip"}, {"point", {thickness, 0.5 * width, L}}}}}};
}

CouplerSettings coupling(double end) {
  CouplerSettings settings;
  settings.time = {end, dt, dt / 256};
  settings.output_interval = 10 * end;
  settings.participants = {{"soil", true}, {"structure", false}};
  settings.interfaces = {{"wall", "soil", "structure"}};
  settings.coupling.acceleration.method = "mvqn";
  settings.coupling.convergence.displacement = {v0 * dt, 1e-5, 1e-9, {}};
  settings.coupling.convergence.force = {1e3, 1e-5, 1, {}};
  settings.coupling.mapping.tolerance = 1e-6;
  return settings;
}

std::size_t column(const Solver& side, const std::string& name) {
  const auto names = side.probe_names();
  return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

double impulse_on(const Witness& soil) {
  double sum = 0, before = 0;
  for (std::size_t n = 0; n < soil.answers.size(); ++n) {
    const auto& f = soil.answers[n].at("wall");
    for (std::size_t v = 0; v < f.size(); v += 3) sum += f[v] * (soil.time[n] - before);
    before = soil.time[n];
  }
  return sum;
}

struct Impact {
  double swing = 0;              // largest of the tip [m]
  double lost = 0, impulse = 0;  // momentum of the sphere, impulse on the wall [N s]
  std::size_t steps = 0;
};
Impact impact(double restitution, double end, const Json& shape = {{"radius", R}},
              double length = R) {
  Json settings = soil_settings("interfaces");
  settings["boulders"][0]["shape"] = shape;
  settings["boulders"][0]["centre"][0] = -length - gap;
  settings["boulders"][0]["restitution"] = restitution;
  settings["bodies"][0]["mesh"] = box({-2, -0.5, 0}, {-1.75, -0.25, 0.25}, {1, 1, 1}, "hex8");
  const auto soil = make_mpm(settings);
  const auto structure = make_fem(wall_settings(E));
  Witness soil_side(*soil), structure_side(*structure);
  run_coupled(coupling(end), soil_side, structure_side);
  Impact found{.lost = m * (v0 - probe(*soil, "stone.vx")),
               .impulse = impulse_on(soil_side),
               .steps = soil_side.time.size()};
  for (const auto& row : structure_side.probe_rows) {
    found.swing = std::max(found.swing, row[column(structure_side, "tip.ux")]);
  }
  return found;
}

void impulse_row(const std::string& what, const Impact& found) {
  verify({.id = "VB9",
          .what = what + "impulse on the wall over the momentum that the sphere lost",
          .exact = found.lost,
          .computed = found.impulse,
          .bound = 1e-6,
          .unit = "N s"});
}

double tip_mass() {
  return 33. / 140 * concrete * L * width * thickness;
}

/// Swing of the tip after a plastic impact [m].
double plastic_swing() {
  const double k = 3 * E * width * std::pow(thickness, 3) / 12 / std::pow(L, 3);
  return m * v0 / (m + tip_mass()) / std::sqrt(k / (m + tip_mass()));
}

/// Plastic impact: sphere and the mass that stands for the beam's first mode share the momentum,
/// then they swing on its stiffness: the tip by V / w. Waves in the beam are left out.
TEST(VB9_BoulderOnCantilever, swings_as_after_a_plastic_impact) {
  const Impact found = impact(1, 0.0125);
  const std::string what = "sphere of 1.4 t, 5 m/s, on a cantilever of concrete, coupled: ";
  verify({.id = "VB9",
          .what = what + "swing of the tip",
          .exact = plastic_swing(),
          .computed = found.swing,
          .bound = 0.2,
          .unit = "m",
          .limitation = "waves in the beam, which the one mode of the closed form leaves out"});
  impulse_row(what, found);
}

/// An ellipsoid of the same mass that hits with the end of an axis does the same.
TEST(VB9_BoulderOnCantilever, an_ellipsoid_on_its_axis) {
  const Impact found = impact(1, 0.0125, {{"ellipsoid", {1.25 * R, R, 0.8 * R}}}, 1.25 * R);
  const std::string what = "ellipsoid of 1.4 t, 5 m/s, along its axis on the cantilever, coupled: ";
  verify({.id = "VB9",
          .what = what + "swing of the tip",
          .exact = plastic_swing(),
          .computed = found.swing,
          .bound = 0.2,
          .unit = "m",
          .limitation = "waves in the beam, which the one mode of the closed form leaves out"});
  impulse_row(what, found);
}

/// Impacts that take energy cut no step.
TEST(VB9_BoulderOnCantilever, with_a_restitution_below_one) {
  for (const double restitution : {0.2, 0.4}) {
    const Impact found = impact(restitution, 0.003);
    EXPECT_EQ(found.steps, 24) << restitution;
    EXPECT_GT(found.lost, 0.4 * m * v0) << restitution;
    impulse_row(fmt::format("the same, restitution {}, to 3 ms: ", restitution), found);
  }
}

/// A sphere and a block of soil against a wall that hardly bends are as against one that is rigid.
TEST(VB13_StiffWall, is_the_limit_of_a_rigid_one) {
  const double end = 0.006;
  Json settings = soil_settings("interfaces");
  settings["bodies"][0]["velocity"] = {v0, 0, 0};
  const auto soil = make_mpm(settings);
  const auto structure = make_fem(wall_settings(1e4 * E));
  Witness soil_side(*soil), structure_side(*structure);
  run_coupled(coupling(end), soil_side, structure_side);

  settings.erase("interfaces");
  settings["rigid_walls"] = soil_settings("rigid_walls")["rigid_walls"];
  const auto alone = make_mpm(settings);
  run_steps(*alone, dt, static_cast<int>(std::lround(end / dt)));
  const std::string what = "sphere and soil of 5 m/s on a wall of 3e14 Pa, coupled: ";
  verify({.id = "VB13",
          .what = what + "speed of the sphere over that at a rigid wall",
          .exact = probe(*alone, "stone.vx"),
          .computed = probe(*soil, "stone.vx"),
          .bound = 1e-3,
          .unit = "m/s"});
  verify({.id = "VB13",
          .what = what + "momentum of the soil over that at a rigid wall",
          .exact = probe(*alone, "momentum_x"),
          .computed = probe(*soil, "momentum_x"),
          .bound = 1e-3,
          .unit = "kg m/s"});
}

}  // namespace
}  // namespace gabion::test
