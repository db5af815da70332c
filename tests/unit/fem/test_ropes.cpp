// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "fem_solver/materials/brake.hpp"
#include "tests/unit/fem/line_scene.hpp"

namespace gabion::test {
namespace {

/// Two cables of length 5, E A 1e6 on the length in the mesh, force 1e4, and 5e3 in the middle:
/// closed form, by a scalar equation.
TEST(Ropes, prestressed_rope_with_a_force_in_the_middle) {
  const TemporaryMesh mesh(chain(10, 2).file());
  Json material = line_material("cable", 9.9e8, 1e-3);
  material["pretension"] = 1e4;
  Json json = line_scene(2, mesh.path(), material);
  json["analysis"] = "static";
  json["supports"] = {{{"group", "low"}}, {{"group", "high"}}};
  json["loads"] = {{{"point", {5, 0}}, {"force", {0, -5e3}}}};
  json["newton"] = {{"residual_tolerance", 1e-11}};
  json["probes"] = {{{"name", "M"}, {"point", {5, 0}}}};
  const auto solver = fem_solver<2>(json);
  advance(*solver, 1, 1);
  const double d = -probe(*solver, "M.uy"), l = std::hypot(5, d),
               N = probe(*solver, "axial_max_rope");
  EXPECT_NEAR(d, 0.667886, 1e-6);
  EXPECT_NEAR(N, 18882.0, 0.05);
  EXPECT_NEAR(N, 1e4 + 1e6 * (l - 5) / 5, 1e-4);
  EXPECT_NEAR(2 * N * d / l, 5e3, 1e-4);
}

/// A net of 8 x 8 meshes, 2 m x 2 m, rim fixed, without slope stiffness but for its prestrain.
TEST(Ropes, square_net_under_a_force) {
  LineText text;
  std::vector<std::vector<int>> lines;
  std::vector<int> rim;
  for (int j = 0; j <= 8; ++j) {
    for (int i = 0; i <= 8; ++i) {
      text.nodes.push_back({0.25 * i, 0.25 * j, 0});
      const int node = 9 * j + i + 1;
      const bool on_rim = i % 8 == 0 || j % 8 == 0;
      if (on_rim) rim.push_back(node);
      if (i > 0 && j % 8 != 0) lines.push_back({node - 1, node});
      if (j > 0 && i % 8 != 0) lines.push_back({node - 9, node});
    }
  }
  std::erase_if(rim, [](int node) { return node == 1 || node == 9 || node == 73 || node == 81; });
  text.lines = {{"rope", lines}};
  text.points = {{"rim", rim}};
  const TemporaryMesh mesh(text.file());
  Json material = line_material("cable", 3e9, 1e-4);
  material["pretension"] = 300;
  Json json = line_scene(3, mesh.path(), material);
  json["analysis"] = "static";
  json["supports"] = {{{"group", "rim"}, {"report_reaction", true}}};
  json["loads"] = {{{"point", {1, 1, 0}}, {"force", {0, 0, -1e3}}, {"table", {{1, 1}, {2, 5}}}}};
  json["probes"] = {{{"name", "M"}, {"point", {1, 1, 0}}}};
  json["newton"] = {{"residual_tolerance", 1e-11}};
  const auto solver = fem_solver<3>(json);
  advance(*solver, 1, 1);
  EXPECT_NEAR(-probe(*solver, "M.uz"), 0.0932181, 1e-7);
  EXPECT_NEAR(probe(*solver, "axial_max_rope"), 1755.58, 0.005);
  EXPECT_NEAR(probe(*solver, "reaction_rim_z"), 1e3, 1e-6);
  advance(*solver, 2, 1);
  EXPECT_NEAR(-probe(*solver, "M.uz"), 0.1706821, 1e-7);
  EXPECT_NEAR(probe(*solver, "axial_max_rope"), 5106.98, 0.005);
}

/// A rope 110 m long over a span of 100 m, 20 N/m, from a straight line without any force.
/// @returns  sag [m] and largest force [N]
std::pair<double, double> hanging_rope(int cells, double stiffness) {
  const TemporaryMesh mesh(chain(100, cells).file());
  Json material = line_material("cable", stiffness / 1e-3, 1e-3, 2000);
  material["length_ratio"] = 1.1;
  Json json = line_scene(2, mesh.path(), material);
  json["analysis"] = "static";
  json["gravity"] = {0, -10};
  json["supports"] = {{{"group", "low"}}, {{"group", "high"}}};
  json["probes"] = {{{"name", "M"}, {"point", {50, 0}}}};
  json["newton"] = {{"max_iterations", 200}};
  const auto solver = fem_solver<2>(json);
  advance(*solver, 1, 1);
  return {-probe(*solver, "M.uy"), probe(*solver, "axial_max_rope")};
}

TEST(Ropes, sag_of_a_slack_rope) {
  const auto [stiff, stiff_force] = hanging_rope(40, 1e6);
  EXPECT_NEAR(stiff, 20.199, 0.02);
  const auto [soft, soft_force] = hanging_rope(40, 1e5);
  EXPECT_NEAR(soft, 21.582, 0.02);
  const auto [finer, finer_force] = hanging_rope(80, 1e5);
  EXPECT_NEAR((4 * finer - soft) / 3, 21.582, 1e-3);
  EXPECT_NEAR(finer_force, 1634.32, 0.01 * 1634.32);
}

/// A mass of 1000 kg at the end of a rope of 10 m that is slack over 5 m.
Json falling_mass(const std::string& file, const std::string& law) {
  Json material = line_material(law, 2e6 / 1e-2, 1e-2, 2e4);
  material["length_ratio"] = 2;
  Json json = line_scene(2, file, material);
  json["mass"] = "lumped";
  json["gravity"] = {-10, 0};
  json["supports"] = {{{"group", "high"}}};
  return json;
}

LineText hanging_line() {
  return {.nodes = {{-5, 0, 0}, {0, 0, 0}},
          .lines = {{"rope", {{1, 2}}}},
          .points = {{"high", {2}}, {"low", {1}}}};
}

/// m g (5 + s) = k s^2 / 2 at the lowest point; the mass flies up through its place again and
/// again.
/// @returns  largest change of energy that is not the work of weight, over the largest elastic one
double energy_error(double dt, const Json& scheme) {
  const TemporaryMesh mesh(hanging_line().file());
  Json json = falling_mass(mesh.path(), "cable");
  json["time_integration"] = scheme;
  json["gravity"] = {-10, 0.5};  // swings, too
  const auto solver = fem_solver<2>(json);
  double worst = 0, largest = 0;
  for (int n = 1; n * dt < 10; ++n) {
    advance(*solver, n, dt);
    largest = std::max(largest, probe(*solver, "elastic_energy"));
    worst = std::max(worst, probe(*solver, "kinetic_energy") + probe(*solver, "elastic_energy") -
                                probe(*solver, "external_work"));
  }
  return worst / largest;
}

TEST(Ropes, slack_and_taut_by_turns_make_no_energy) {
  const Json trapezoid = {{"scheme", "newmark"}};
  const double coarse = energy_error(0.01, trapezoid), fine = energy_error(0.0025, trapezoid);
  EXPECT_LT(fine, 0.01);
  EXPECT_LT(fine, coarse);
  for (const double dt : {0.05, 0.01}) {
    const double made = energy_error(dt, {{"scheme", "generalized_alpha"}, {"rho_inf", 0.0}});
    EXPECT_LT(made, 0.01);
  }
}

TEST(Ropes, brake_by_table) {
  const TemporaryMesh mesh(chain(1, 1).file());
  for (const int steps : {3, 300}) {
    Json material = line_material("brake", 2e5 / 1e-3, 1e-3);
    material["brake_table"] = {{0, 50e3}, {0.3, 60e3}, {0.8, 55e3}, {1.2, 80e3}};
    Json json = line_scene(2, mesh.path(), material);
    json["analysis"] = "static";
    json["supports"] = {{{"group", "low"}}};
    json["prescribed"] = {
        {{"group", "high"}, {"component", "y"}, {"rate", 0.0}},
        {{"group", "high"}, {"component", "x"}, {"table", {{0, 0}, {1, 1}, {2, 0.6}, {3, 2}}}}};
    const auto solver = fem_solver<2>(json);
    for (int n = 1; n <= steps; ++n) advance(*solver, n, 3.0 / steps);
    EXPECT_NEAR(probe(*solver, "axial_max_rope"), 80e3, 1e-5);
    EXPECT_NEAR(probe(*solver, "brake_run_rope"), 1.6, 1e-12);
    EXPECT_NEAR(probe(*solver, "brake_work"), 104250, 1e-6);
  }
}

TEST(Ropes, brake_stops_at_its_limit) {
  const fem::Brake brake({0, 1}, {100, 200}, 0.5);
  EXPECT_DOUBLE_EQ(brake.balance(10, 0, 1000).run, 0.5);
  EXPECT_DOUBLE_EQ(brake.balance(10, 0, 1000).slope, 1000);
  EXPECT_DOUBLE_EQ(brake.balance(0.05, 0, 1000).run, 0);
  EXPECT_DOUBLE_EQ(brake.work(0.5), 62.5);
}

/// Energy at the lowest point: work of the brake 56298.2 J over 1.12596 m, 6250 J stored.
TEST(Ropes, brake_catches_a_falling_mass) {
  const TemporaryMesh mesh(hanging_line().file());
  Json json = falling_mass(mesh.path(), "brake");
  json["gravity"] = {-9.81, 0};
  json["materials"][0]["brake_table"] = {{0, 50e3}};
  const auto solver = fem_solver<2>(json);
  double run = 0, work = 0, largest = 0, imbalance = 0;
  for (int n = 1; n <= 1500; ++n) {
    advance(*solver, n, 0.001);
    run = probe(*solver, "brake_run_rope");
    work = probe(*solver, "brake_work");
    largest = std::max(largest, probe(*solver, "axial_max_rope"));
    imbalance = std::max(
        imbalance, std::abs(probe(*solver, "kinetic_energy") + probe(*solver, "elastic_energy") +
                            work - probe(*solver, "external_work")));
  }
  EXPECT_NEAR(run, 1.12596, 1e-3 * 1.12596);
  EXPECT_NEAR(work, 56298.2, 60);
  EXPECT_NEAR(largest, 50e3, 1e-6);
  EXPECT_LT(imbalance, 1e-3 * 62548);
}

}  // namespace
}  // namespace gabion::test
