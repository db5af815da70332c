// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "fem_solver/materials/brake.hpp"
#include "tests/unit/fem/line_scene.hpp"

namespace gabion::test::test_ropes {
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

/// A rope 5 % longer than its span hangs at rest from the start: with "initial_equilibrium" and
/// the default settings. Its sag is that of the catenary, 1.393 m.
TEST(Ropes, slack_rope_at_rest_at_the_start) {
  for (const int cells : {2, 20}) {
    const TemporaryMesh mesh(chain(10, cells).file());
    Json material = line_material("cable", 1e11, 1e-4, 7850);
    material["length_ratio"] = 1.05;
    Json json = line_scene(2, mesh.path(), material);
    json["gravity"] = {0, -9.81};
    json["initial_equilibrium"] = true;
    json["supports"] = {{{"group", "low"}}, {{"group", "high"}}};
    json["probes"] = {{{"name", "M"}, {"point", {5, 0}}}};
    const auto solver = fem_solver<2>(json);
    const double two_straight_parts = std::sqrt(5.25 * 5.25 - 25);
    EXPECT_NEAR(-probe(*solver, "M.uy"), cells == 2 ? two_straight_parts : 1.393, 5e-3);
  }
}

/// A rope with a pretension and a bar without it in a row, and a slack rope over them whose middle
/// nothing holds: "initial_equilibrium" without any load finds the common force of rope and bar,
/// and nothing moves from then on.
TEST(Ropes, pretension_alone_is_in_equilibrium_at_the_start) {
  LineText text = chain(2, 2);
  text.nodes.push_back({1, 1, 0});
  text.lines = {{"rope", {{1, 2}}}, {"bar", {{2, 3}}}, {"slack", {{1, 4}, {4, 3}}}};
  const TemporaryMesh mesh(text.file());
  Json rope = line_material("cable", 1e9, 1e-3, 100), bar = line_material("truss", 5e8, 1e-3, 100);
  rope["pretension"] = 1e3;
  Json json = line_scene(2, mesh.path(), rope);
  bar["group"] = "bar";
  json["materials"].push_back(bar);
  json["materials"].push_back(line_material("cable", 1e9, 1e-3, 100));
  json["materials"][2].update({{"group", "slack"}, {"length_ratio", 1.1}});
  json["initial_equilibrium"] = true;
  json["supports"] = {{{"group", "low"}},
                      {{"group", "high"}, {"report_reaction", true}},
                      {{"group", "middle"}, {"components", {"y"}}}};
  json["probes"] = {{{"name", "M"}, {"point", {1, 0}}}};
  const auto solver = fem_solver<2>(json);
  const double stiffness = 1e6 * (1 + 1e3 / 1e6), moved = 1e3 / (stiffness + 5e5);
  for (int n = 0; n <= 3; ++n) {
    if (n > 0) advance(*solver, n, 1e-3);
    EXPECT_NEAR(probe(*solver, "M.ux"), -moved, 1e-9) << n;
    EXPECT_NEAR(probe(*solver, "axial_max_rope"), 5e5 * moved, 1e-3) << n;
    EXPECT_EQ(probe(*solver, "axial_max_slack"), 0) << n;
    EXPECT_NEAR(probe(*solver, "axial_max_bar"), 5e5 * moved, 1e-3) << n;
    EXPECT_NEAR(probe(*solver, "reaction_high_x"), 5e5 * moved, 1e-3) << n;
    EXPECT_NEAR(probe(*solver, "elastic_energy"),
                0.5 * std::pow(5e5 * moved, 2) * (1 / stiffness + 1 / 5e5), 1e-6)
        << n;
  }
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
  if (!scheme.is_null()) json["time_integration"] = scheme;
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
    EXPECT_EQ(made, energy_error(dt, Json())) << "that of the default";
  }
}

/// Two slack ropes in a row between two walls, with a mass that flies to and fro between them.
/// @returns  largest kinetic and elastic energy and work of the weight over the energy at the start
double energy_between_two_ropes(double dt, const Json& scheme) {
  const TemporaryMesh mesh(chain(2, 2).file());
  Json material = line_material("cable", 1e11, 5e-5, 7850);
  material["length_ratio"] = 1.002;
  Json json = line_scene(2, mesh.path(), material);
  json["supports"] = {{{"group", "low"}}, {{"group", "high"}}};
  json["initial_velocity"] = {3, 1.7};
  if (!scheme.is_null()) json["time_integration"] = scheme;
  const auto solver = fem_solver<2>(json);
  const double start = probe(*solver, "kinetic_energy");
  double most = 0;
  for (int n = 1; n * dt < 0.5; ++n) {
    advance(*solver, n, dt);
    most = std::max(most, probe(*solver, "kinetic_energy") + probe(*solver, "elastic_energy"));
  }
  return most / start;
}

TEST(Ropes, default_scheme_makes_no_energy_between_two_ropes) {
  EXPECT_GT(energy_between_two_ropes(1e-3, {{"scheme", "newmark"}}), 2);
  for (const double dt : {4e-3, 1e-3, 2.5e-4, 5e-5}) {
    EXPECT_LE(energy_between_two_ropes(dt, Json()), 1 + 1e-9) << dt;
  }
}

/// A mass at a slack rope, without weight: the true forces are zero.
TEST(Ropes, slack_rope_and_mass_fly_straight) {
  const TemporaryMesh mesh(hanging_line().file());
  for (const Json& scheme :
       {Json{{"scheme", "newmark"}}, Json{{"scheme", "bossak"}}, Json{{"rho_inf", 0.0}}}) {
    Json json = falling_mass(mesh.path(), "cable");
    json.erase("gravity");
    json["initial_velocity"] = {-3, 0.1};
    json["time_integration"] = scheme;
    json["probes"] = {{{"name", "M"}, {"point", {-5, 0}}}};
    const auto solver = fem_solver<2>(json);
    const double dt = 1.3e-3;
    for (int n = 1; n <= 1000; ++n) advance(*solver, n, dt);
    EXPECT_NEAR(probe(*solver, "M.ux"), -3 * 1000 * dt, 1e-9) << scheme;
    EXPECT_NEAR(probe(*solver, "M.uy"), 0.1 * 1000 * dt, 1e-9) << scheme;
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

/// A heavy rope with a brake of 20 kN, pulled by 90 kN and pushed by 40 kN from step to step. Its
/// anchor gets the force of the rope, between 0 and 20 kN, and the momentum of all is the impulse
/// of load and reaction, by the trapezoidal rule.
TEST(Ropes, anchor_bears_the_force_of_the_rope) {
  constexpr double dt = 1e-3, mass = 100;
  constexpr int steps = 200;
  const TemporaryMesh mesh(hanging_line().file());
  for (const char* spread : {"consistent", "lumped"}) {
    Json material = line_material("brake", 2e8, 1e-2, mass / 5e-2);
    material["brake_table"] = {{0, 20e3}};
    Json json = line_scene(2, mesh.path(), material);
    json["mass"] = spread;
    json["time_integration"] = {{"scheme", "newmark"}};
    json["supports"] = {{{"group", "high"}, {"report_reaction", true}}};
    json["point_masses"] = {{{"point", {-5, 0}}, {"mass", 50}}};
    Json rows = Json::array();
    for (int n = 0; n <= steps; ++n) rows.push_back({n * dt, n % 2 == 0 ? 90.0 : -40.0});
    json["loads"] = {{{"point", {-5, 0}}, {"force", {-1e3, 0}}, {"table", rows}}};
    const auto solver = fem_solver<2>(json);
    double force = -90e3, reaction = 0, momentum = 0, largest = 0;
    for (int n = 1; n <= steps; ++n) {
      advance(*solver, n, dt);
      const double force_n = force, reaction_n = reaction, momentum_n = momentum;
      force = -1e3 * double(rows[n][1]);
      reaction = probe(*solver, "reaction_high_x");
      momentum = probe(*solver, "momentum_x");
      EXPECT_NEAR(reaction, probe(*solver, "axial_max_rope"), 1e-6) << spread;
      EXPECT_GE(reaction, -1e-6) << spread;
      EXPECT_LE(reaction, 20e3 + 1e-6) << spread;
      EXPECT_NEAR(momentum - momentum_n, dt / 2 * (force + force_n + reaction + reaction_n), 1e-6)
          << spread;
      largest = std::max(largest, reaction);
    }
    EXPECT_NEAR(largest, 20e3, 1e-6) << spread;
  }
}

}  // namespace
}  // namespace gabion::test::test_ropes
