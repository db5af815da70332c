// SPDX-License-Identifier: BSD-3-Clause
// Spheres in space that float on a fluid, and that fall on dry grains.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {
namespace {

constexpr double g = 9.81;

/// A box of soil of a width and a depth, in cells of one size, with a sphere over its middle.
struct Pit {
  double width = 1, depth = 1, above = 0, cell = 0.1;  // above: empty cells' height
  double radius = 0, density = 0, centre = 0, speed = 0;
};

Json pit_scene(const Pit& pit, const Json& material, const std::string& bottom) {
  const auto cells = [&](double size) { return static_cast<int>(std::lround(size / pit.cell)); };
  const double w = pit.width, top = pit.depth + pit.above;
  Json scene = {
      {"dimension", 3},
      {"grid", box({0, 0, 0}, {w, w, top}, {cells(w), cells(w), cells(top)}, "hex8")},
      {"gravity", {0, 0, -g}},
      {"walls", {wall("bottom", bottom)}},
      {"time_integration", {{"scheme", "explicit"}}},
      {"step_control", {{"strain", nullptr}}},
      {"bodies",
       {body("soil",
             box({0, 0, 0}, {w, w, pit.depth}, {cells(w), cells(w), cells(pit.depth)}, "hex8"), 8,
             material)}},
      {"boulders",
       {{{"name", "ball"},
         {"shape", {{"radius", pit.radius}}},
         {"density", pit.density},
         {"centre", {w / 2, w / 2, pit.centre}},
         {"velocity", {0, 0, -pit.speed}}}}}};
  for (const char* side : {"left", "right", "front", "back"}) {
    scene["walls"].push_back(wall(side, "slip"));
  }
  return scene;
}

/// Part of a sphere of radius 1 below the plane `depth` above its lowest point, by its volume.
double share_below(double depth) {
  return depth * depth * (3 - depth) / 4;
}

/// VB8: a sphere without friction in a fluid sinks until it has displaced its mass. It begins a
/// little too deep; what the fluid rises by is counted.
/// @param exact  depth of its lowest point over its radius
void float_in_fluid(double ratio, double exact, double bound) {
  EXPECT_NEAR(share_below(exact), ratio, 1e-6);
  constexpr double R = 0.25, rho = 1800;
  const double volume = 4 * std::numbers::pi / 3 * R * R * R;
  Pit pit{.width = 1.2,
          .depth = 0.8,
          .above = 0.4,
          .cell = 1.2 / 18,
          .radius = R,
          .density = ratio * rho,
          .centre = 0.78 - R * (exact - 1)};
  const Json fluid = {
      {"law", "newtonian"}, {"density", rho}, {"sound_speed", 30}, {"viscosity", 200}};
  Json scene = pit_scene(pit, fluid, "slip");
  scene["gravity_ramp"] = {{"duration", 0.1}, {"shape", "smooth"}};
  scene["boulders"][0]["soil_friction"] = 0;
  scene["boulders"][0]["soil_inside"] = "remove";
  scene["boulders"][0]["free_from"] = 0.15;
  const auto solver = make_mpm(scene);
  constexpr double dt = 5e-3;
  run_steps(*solver, dt, 160);
  constexpr int count = 50;
  double height = 0, drift = 0;  // of the second half against the first
  for (int n = 1; n <= count; ++n) {
    run_steps(*solver, dt, 1, 160 + n);
    const double z = probe(*solver, "ball.z");
    height += z / count;
    drift += (2 * n > count ? z : -z) / (count / 2);
  }
  EXPECT_LT(std::abs(drift), 0.01 * R) << ratio;
  const double level = (probe(*solver, "mass") / rho + ratio * volume) / (pit.width * pit.width);
  verify(
      {.id = "VB8",
       .what = fmt::format("sphere of {} of the density of a fluid, 3.75 cells in radius, floats: "
                           "depth over radius",
                           ratio),
       .exact = exact,
       .computed = (level - height + R) / R,
       .bound = bound});
}

TEST(VB8_Floating, sphere_in_a_fluid) {
  float_in_fluid(0.3, 0.726515, 0.03);
  float_in_fluid(0.5, 1, 0.03);
  float_in_fluid(0.8, 1.425719, 0.03);
}

/// VB10: a steel ball of 25.4 mm falls on glass beads; its depth lies between the laws of Uehara et
/// al. (2003) and of Katsuragi and Durian (2013).
void fall_on_beads(double drop, double uehara, double katsuragi) {
  constexpr double D = 0.0254;
  Pit pit{.width = 4 * D,
          .depth = 3 * D,
          .above = 2 * D,
          .cell = D / 6,
          .radius = D / 2,
          .density = 7970,
          .centre = 3.5 * D + 1e-4,
          .speed = std::sqrt(2 * g * drop)};
  Json beads = elastic_soil("mohr_coulomb", 1e6, 0.3, 1520);
  beads["friction_angle"] = 24;
  Json scene = pit_scene(pit, beads, "fixed");
  scene["bodies"][0]["initial_stress"] = {{"k0", "jaky"}, {"surface", pit.depth}};
  scene["boulders"][0]["soil_friction"] = std::tan(24 * std::numbers::pi / 180);
  const auto solver = make_mpm(scene);
  double lowest = pit.centre;
  for (int n = 1; n <= 280; ++n) {
    run_steps(*solver, 2.5e-4, 1, n);
    lowest = std::min(lowest, probe(*solver, "ball.z"));
  }
  EXPECT_LT(std::abs(probe(*solver, "ball.vz")), 0.02 * pit.speed);  // it has come to rest
  const double middle = 0.5 * (uehara + katsuragi);
  verify(
      {.id = "VB10",
       .what = fmt::format("steel ball of 25.4 mm dropped by {} m on beads, 6 cells across: depth "
                           "of the crater, exact: the middle of two laws of experiments, bound: "
                           "half of what they differ by",
                           drop),
       .exact = middle,
       .computed = 1e3 * (pit.depth + D / 2 - lowest),
       .bound = (katsuragi - middle) / middle,
       .unit = "mm"});
}

TEST(VB10_Crater, ball_on_beads) {
  fall_on_beads(0.1, 31.7, 42.1);
  fall_on_beads(0.2, 38.6, 50.8);
}

}  // namespace
}  // namespace gabion::test
